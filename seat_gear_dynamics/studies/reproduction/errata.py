"""Where the paper contradicts itself or leaves something open, with the numbers that show it and what is done."""

from dataclasses import dataclass

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.studies.calibration.freedom import STEEL_DENSITY, disc_mass


@dataclass(frozen=True)
class Erratum:
    """One contradiction or gap."""

    place: str
    finding: str
    followed: str
    """What this project does about it."""


def errata(train: GearTrain) -> list[Erratum]:
    """Return the errata of the paper, their numbers computed from `train`."""
    s1 = train.gears[0]
    inertia = disc_mass(s1) * s1.tooth.pitch_radius**2 / 2
    derived, published = train.derived_time_scale, train.with_time_scale("published").model.time_scale
    at_one = derived / s1.teeth / RPM
    static = train.static_forces(300.0)[0]
    ratio12, ratio34 = 4.529e8 / 2.2645e5, 5.051e8 / 2.526e6
    return [
        Erratum(
            "Table 1",
            f"inertias are headed kg·mm²; a steel disc of s1's size ({STEEL_DENSITY:.0f} kg/m³) has "
            f"{inertia:.2g} kg·m², Table 1 prints {s1.inertia:.3g}",
            "kg·m²",
        ),
        Erratum(
            "Table 4",
            f"headed µm; the static chain gives {static:.0f} N for 300 N·m, and its averages are 5395 to 5655",
            "newtons",
        ),
        Erratum(
            "Table 2",
            f"`C23 = 2.526E+06`: there is no mesh 23. C12 is its contact stiffness over {ratio12:.0f}, "
            f"this over {ratio34:.0f}",
            "C34 = 2.526e5 N·s/m",
        ),
        Erratum(
            "(15)",
            f"gives {derived:.4g} rad/s, with which Ω = 1 lies at {at_one:.0f} r/min; the text's own pairs of Ω and "
            f"speed imply {published:.1f} rad/s, {derived / published:.1f} times less",
            "two named time scales, `published` and `derived`, or a measured one: (15) in the equations, the bench's "
            "in its time",
        ),
        Erratum(
            "(10)-(13)",
            "the torsional lines carry δ where all others carry f(δ): energy is then not conserved at separation",
            "f(δ) throughout; the printed form is the variant `backlash_in_torsion: false`",
        ),
        Erratum(
            "(20)",
            "lacks the factor 1/6",
            "the classical method",
        ),
        Erratum(
            "section 3.1",
            "says chaos at Ω = 0.7, which its list of bands to avoid does not hold, and Figs 9 and 10 have one caption",
            "0.7 counts as calm, as the list and the conclusions have it",
        ),
        Erratum(
            "Table 3 and section 4.2",
            "loads are headed N·m in the table and N in the text",
            "N·m",
        ),
        Erratum(
            "section 3.3",
            "gives neither b_c nor Ω for the dimensionless backlash; with b_c = 10 µm its calm range would hold the "
            "very 20 µm that section 3.4 finds chaotic at this load",
            "Ω = 1, and b_c read off so that most of the claim holds (C10)",
        ),
        Erratum(
            "throughout",
            "masses, supports and their damping, transmission error, harmonics of k(t), b_c and initial states are not "
            "given",
            "calibrated against C1-C5 and C7-C10 (docs/calibration.md); every value of the description says where it "
            "is from",
        ),
        Erratum(
            "section 3",
            f"loads of 600 N·m enter the model as {train.model.load_scale:.4g} of their static force "
            f"({train.static_forces(600.0)[0]:.0f} N in P12): with the whole of it no set was found that meets C3 and "
            f"C9. A seat adjuster carries a few N·m",
            "`load_scale`, shown wherever a force or a load is",
        ),
        Erratum(
            "(10)-(13)",
            "print no support damping, which Fig. 7 draws: without it motions off the line of action barely decay, and "
            "a slow transient passes for quasi-periodic motion",
            "support damping as Fig. 7 has it; a motion whose section still contracts is called undecided",
        ),
    ]
