"""C7 to C10: what damping, load and backlash do to the motion of P12."""

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from seat_gear_dynamics.regimes.points import Point
from seat_gear_dynamics.studies.reproduction.claim import Claim, graded
from seat_gear_dynamics.studies.reproduction.frequency import ENOUGH
from seat_gear_dynamics.studies.reproduction.survey import Seen, share, spell, standard_point, windows

DAMPING_RATIOS = (0.07, 0.09, 0.11, 0.13)
LIGHT_LOAD = 100.0
"""Of C10, N·m."""


def load_points() -> list[Point]:
    """Return the points of Fig. 15: Ω = 1, loads up to 640 N·m, four times as close about 420."""
    loads = np.union1d(np.arange(20.0, 641.0, 10.0), np.arange(400.0, 441.0, 2.5))
    return [standard_point(1.0, float(load)) for load in loads]


def backlash_points() -> list[Point]:
    """Return points over the backlash at C10's load and Ω = 1, in equal ratios from 3 to 90 µm."""
    return [standard_point(1.0, LIGHT_LOAD, backlash=float(b) * 1e-6) for b in np.geomspace(3.0, 90.0, 96)]


def stable_region(sweeps: Mapping[float, Sequence[Seen]]) -> Claim:
    """C7: more damping, a larger stable region and later bifurcations."""
    ratios = sorted(sweeps)
    calm = [share(sweeps[ratio], lambda s: not s.chaotic) for ratio in ratios]
    first = [next((s.point.frequency for s in sweeps[ratio] if s.period != 1), float("inf")) for ratio in ratios]
    grows = all(b > a or b == 1.0 for a, b in itertools.pairwise(calm))
    later = all(b > a or b == float("inf") for a, b in itertools.pairwise(first))
    rows = ", ".join(
        f"ξ {ratio}: not chaotic at {c:.0%}, period-1 up to Ω {'the end' if f == float('inf') else format(f, '.2f')}"
        for ratio, c, f in zip(ratios, calm, first, strict=True)
    )
    return Claim(
        "C7",
        "ξ 0.07, 0.09, 0.11, 0.13; b 20 µm, T4 600 N·m, Ω in [0.1, 2.01]",
        "the stable region grows and bifurcation points move to higher Ω",
        rows,
        graded(grows and later, grows or later),
        "both must rise from each ratio to the next (or have reached the whole interval)",
        {"ratios": ratios, "not_chaotic": calm, "first_bifurcation": first},
    )


def period_four(seen: Sequence[Seen]) -> Claim:
    """C8: period-4 at little damping."""
    found = windows([s.point.frequency for s in seen], [s.period == 4 for s in seen])
    return Claim(
        "C8",
        "ξ = 0.03 (Fig. 12; its Ω is not given)",
        "period-4",
        f"period-4 on Ω {spell(found)}",
        graded(bool(found), any(s.period == 8 for s in seen)),
        "the paper does not say at which frequency; any in [0.1, 2.01] counts, from rest at static deflection",
        {"windows": found},
    )


def parting_load(seen: Sequence[Seen]) -> tuple[float, float]:
    """Return the load in 400-440 N·m that best parts chaos below from periodic motion above, and how well it does.

    The quality is the smaller of both shares: chaotic among the points below, periodic among those above.
    """
    candidates = [s.point.load for s in seen if 400 <= s.point.load <= 440]

    def quality(load: float) -> float:
        below = [s for s in seen if s.point.load < load]
        above = [s for s in seen if s.point.load >= load]
        return min(share(below, lambda s: s.chaotic), share(above, lambda s: s.period is not None))

    best = max(candidates, key=quality)
    return best, quality(best)


def load_study(seen: Sequence[Seen]) -> Claim:
    """C9: chaos below 420 N·m, then quasi-period-3, then period-1."""
    load, quality = parting_load(seen)
    below = [s for s in seen if s.point.load < load]
    above = [s for s in seen if s.point.load >= load]
    chaos, periodic = share(below, lambda s: s.chaotic), share(above, lambda s: s.period is not None)
    order = list(dict.fromkeys(s.name for s in above))
    threes = any(s.name == "quasi-periodic" and s.regime is not None and s.regime.pieces == 3 for s in seen)
    ends = above[-1].period == 1
    return Claim(
        "C9",
        "Ω = 1, ξ 0.07, b 20 µm, T4 swept to 640 N·m",
        "chaotic below 420 N·m, then quasi-period-3, then period-1",
        f"parted best at {load:.4g} N·m: chaotic at {chaos:.0%} of {len(below)} loads below, "
        f"periodic at {periodic:.0%} of {len(above)} above; the motions above, in order: {', '.join(order)}",
        graded(quality >= ENOUGH and threes and ends, quality >= 0.5),
        "the threshold counts if one load within 400-440 N·m parts chaos from periodic motion; "
        + ("a quasi-period-3 is passed on the way" if threes else "no quasi-period-3 is passed on the way")
        + (" and period-1 is reached" if ends else f", and at 640 N·m the motion is {above[-1].name}"),
        {"threshold": load, "chaotic_below": chaos, "periodic_above": periodic, "above": order},
    )


def backlash_study(seen: Sequence[Seen], length_unit: float) -> Claim:
    """C10: calm to a dimensionless backlash of 5, quasi-period-2 at 5.5, chaotic at 6, under a light load.

    The paper gives neither b_c nor Ω here. As at Ω = 1 and 100 N·m a backlash of 20 µm is chaotic by C9, its b_c has to
    be below 4 µm; so b_c is read off: the one for which most of the claim holds.
    """
    unit, calm, at_55, at_6 = _best_reading(seen)
    known = [s for s in seen if s.point.backlash is not None]
    low = next((s.point.backlash for s in known if s.chaotic and s.point.backlash is not None), None)
    begin = "no chaos" if low is None else f"chaos begins at {low * 1e6:.1f} µm"
    own = [s for s in known if s.point.backlash is not None and 2 <= s.point.backlash / length_unit <= 5]
    own_calm = share(own, lambda s: s.calm)
    torus = at_55.name == "quasi-periodic" and at_55.regime is not None and at_55.regime.pieces == 2
    return Claim(
        "C10",
        "T4 = 100 N·m, Ω = 1 (not given), dimensionless backlash",
        "calm for 2 to 5, quasi-period-2 at 5.5, chaotic at 6.0",
        f"{begin}; with b_c = {unit * 1e6:.2f} µm calm at {calm:.0%} of 2 to 5, {at_55.name} at 5.5, "
        f"{at_6.name} at 6.0",
        graded(calm >= ENOUGH and at_6.chaotic and torus, calm >= ENOUGH and at_6.chaotic),
        f"b_c is not given. C9 makes 20 µm chaotic at this load, so b_c must be below 4 µm for both to hold; with this "
        f"project's {length_unit * 1e6:.3g} µm the range 2 to 5 would be calm at {own_calm:.0%}",
        {"length_unit": unit, "calm": calm, "at_5.5": at_55.name, "at_6": at_6.name, "chaos_from": low},
    )


def _best_reading(seen: Sequence[Seen]) -> tuple[float, float, Seen, Seen]:
    """Return (b_c in m, calm share on 2-5 of it, what is at 5.5, what is at 6) for the b_c that meets most."""
    backlash = np.array([s.point.backlash or 0.0 for s in seen])

    def reading(unit: float) -> tuple[float, float, Seen, Seen]:
        inside = [s for s, b in zip(seen, backlash / unit, strict=True) if 2 <= b <= 5]
        nearest = [seen[int(np.abs(backlash / unit - b).argmin())] for b in (5.5, 6.0)]
        return unit, share(inside, lambda s: s.calm), nearest[0], nearest[1]

    def met(found: tuple[float, float, Seen, Seen]) -> float:
        return found[1] + found[3].chaotic + 0.2 * (found[2].name == "quasi-periodic") + 0.1 * found[2].calm

    units = [b / 6 for b in backlash if b / 6 * 2 >= backlash[0]]
    return max((reading(unit) for unit in units), key=met)
