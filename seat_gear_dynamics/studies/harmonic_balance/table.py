"""A response curve as rows of plain values in SI units, for CSV, JSON and figures."""

from seat_gear_dynamics.studies.harmonic_balance.branch import Branch
from seat_gear_dynamics.studies.harmonic_balance.response_curve import ResponseCurve

COLUMNS = (
    "branch",
    "value",
    "period",
    "stable",
    "bifurcation",
    "contact",
    "contact_loss",
    "delta_mean",
    "delta_rms",
    "delta_peak",
    "force_mean",
    "force_min",
    "force_max",
    "force_rms",
    "multiplier_real",
    "multiplier_imag",
)
"""value: of the curve's parameter (frequency Ω, load N·m, damping_ratio, backlash m); period: in mesh periods; delta in
m, rms and peak about the mean; force in N, at the model's load scale; multiplier: the largest one over the period."""

Row = dict[str, int | float | str | bool]


def rows(curve: ResponseCurve) -> list[Row]:
    """Return one row for each motion followed, in the order of COLUMNS, branch by branch along the branch."""
    return [row for number, branch in enumerate(curve.branches) for row in _branch_rows(number, branch)]


def _branch_rows(number: int, branch: Branch) -> list[Row]:
    pair = branch.balance.pair
    kinds = {id(b.motion): b.kind for b in branch.bifurcations}
    found: list[Row] = []
    for motion, stable in zip(branch.motions, branch.stable, strict=True):
        delta = (motion.mean, motion.rms, motion.peak)
        force = motion.force
        forces = (force.mean(), force.min(), force.max(), (force**2).mean() ** 0.5)
        values: list[int | float | str | bool] = [
            number,
            motion.parameter,
            branch.subharmonics,
            bool(stable),
            kinds.get(id(motion), ""),
            motion.contact_state,
            motion.contact_loss,
            *(d * pair.length_unit for d in delta),
            *(float(f) * pair.force_unit for f in forces),
            float(motion.multipliers[0].real),
            float(motion.multipliers[0].imag),
        ]
        found.append(dict(zip(COLUMNS, values, strict=True)))
    return found
