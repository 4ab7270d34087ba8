"""C1 to C6: what the motion of P12 is over the mesh frequency, and those frequencies as speeds."""

from collections.abc import Sequence

import numpy as np

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.train import PUBLISHED_PAIRS
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.points import Point
from seat_gear_dynamics.studies.reproduction.claim import Claim, graded
from seat_gear_dynamics.studies.reproduction.survey import Seen, between, share, spell, standard_point, windows

LOAD = 600.0
FIRST, LAST, STEP = 0.1, 2.01, 0.01
C2_WINDOW = (1.25, 1.33)
"""Where a chaotic window counts as the paper's at 1.29-1.30: half a tenth to either side."""
ENOUGH = 0.95
"""Share of points from which a claim about an interval counts as met: a classification may err at its edges."""
_SETTING = "ξ 0.07, b 20 µm, T4 600 N·m"


def frequency_points(**options: float) -> list[Point]:
    """Return the points of Fig. 8's interval; `options` go to each Point."""
    count = round((LAST - FIRST) / STEP) + 1
    return [standard_point(float(f), LOAD, **options) for f in np.linspace(FIRST, LAST, count)]


def close_points() -> list[Point]:
    """Return points four times as close about the claimed window of C2."""
    return [standard_point(float(f), LOAD) for f in np.arange(C2_WINDOW[0], C2_WINDOW[1] + 1e-9, 0.0025)]


def period_one(seen: Sequence[Seen]) -> Claim:
    """C1: period-1 at low frequency."""
    low = between(seen, 0.1, 0.69)
    met = share(low, lambda s: s.period == 1)
    first = next((s for s in seen if s.period != 1), None)
    until = "throughout the interval" if first is None else f"until {first.name} at Ω = {first.point.frequency:.2f}"
    return Claim(
        "C1",
        f"{_SETTING}, Ω in [0.1, 0.69]",
        "period-1",
        f"period-1 at {met:.0%} of {len(low)} frequencies; {until}",
        graded(met == 1, met >= 0.5),
        "the first bifurcation lies above the claimed interval" if met == 1 else "other motions lie in the interval",
        {"share": met},
    )


def narrow_window(close: Sequence[Seen]) -> Claim:
    """C2: a narrow chaotic window near 1.29."""
    inside = between(close, 1.29, 1.30)
    met = share(inside, lambda s: s.chaotic)
    found = windows([s.point.frequency for s in close], [s.chaotic for s in close])
    motions = sorted({s.name for s in inside})
    return Claim(
        "C2",
        f"{_SETTING}, Ω in [1.29, 1.30]",
        "chaotic",
        f"chaotic at {met:.0%} of {len(inside)} frequencies in it ({', '.join(motions)}); "
        f"chaotic windows in [{C2_WINDOW[0]}, {C2_WINDOW[1]}]: {spell(found, 4)}",
        graded(met >= ENOUGH, bool(found)),
        "a window this narrow moves with every parameter that the paper leaves open; met in part means that a chaotic "
        "window lies near it",
        {"share": met, "windows": found},
    )


def wide_band(seen: Sequence[Seen]) -> Claim:
    """C3: the wide chaotic band."""
    band = between(seen, 1.52, 1.97)
    met = share(band, lambda s: s.chaotic)
    found = windows([s.point.frequency for s in seen], [s.chaotic for s in seen])
    return Claim(
        "C3",
        f"{_SETTING}, Ω in [1.52, 1.97]",
        "chaotic",
        f"chaotic at {met:.0%} of {len(band)} frequencies; everywhere chaotic on {spell(found)}",
        graded(met >= ENOUGH, met >= 0.5),
        f"at least {ENOUGH:.0%} of the frequencies count as the band",
        {"share": met, "windows": found},
    )


def three_curves(seen: Sequence[Seen]) -> Claim:
    """C4: quasi-period-3 at 1.98."""
    at = next(s for s in seen if abs(s.point.frequency - 1.98) < 1e-9)
    pieces = None if at.regime is None else at.regime.pieces
    whole = at.name == "quasi-periodic" and pieces == 3
    part = pieces == 3 or (at.period is not None and at.period % 3 == 0) or at.name == "quasi-periodic"
    told = f"{at.name}, section in {pieces} pieces" if pieces is not None else at.name
    return Claim(
        "C4",
        f"{_SETTING}, Ω = 1.98",
        "quasi-period-3: three closed curves on the section",
        f"{told}; exponent {_exponent(at)}",
        graded(whole, part),
        "three closed curves are a torus of the third iterate; a period of 3, 6, … or three bands are its relatives",
        {"motion": at.name, "pieces": pieces},
    )


def calm_elsewhere(seen: Sequence[Seen]) -> Claim:
    """C5: no chaos outside the two bands."""
    outside = [s for s in seen if not _claimed_chaotic(s.point.frequency)]
    below = [s for s in outside if s.point.frequency < 1.515]
    met, met_below = share(outside, lambda s: s.calm), share(below, lambda s: s.calm)
    strays = windows([s.point.frequency for s in outside], [not s.calm for s in outside])
    names = sorted({s.name for s in outside if not s.calm})
    return Claim(
        "C5",
        f"{_SETTING}, elsewhere in [0.1, 2.01]",
        "not chaotic (yet section 3.1 also says chaos at 0.7)",
        f"periodic or quasi-periodic at {met:.0%} of {len(outside)} frequencies, {met_below:.0%} below 1.52; "
        f"else ({', '.join(names) or 'none'}) on {spell(strays)}",
        graded(met >= ENOUGH, met >= 0.8),
        "undecided motions count against the claim; the neighbourhood of C2's window is left out",
        {"share": met, "share_below": met_below, "strays": strays},
    )


def band_speeds(train: GearTrain) -> Claim:
    """C6: the bands as speeds of s1."""
    published = train.with_time_scale("published")
    derived = train.with_time_scale("derived")
    found = [(rpm, published.speed(frequency) / RPM) for frequency, rpm in PUBLISHED_PAIRS]
    worst = max(abs(own - rpm) for rpm, own in found)
    by_equation = derived.speed(1.0) / RPM
    return Claim(
        "C6",
        "those bands in speed of s1",
        "1349-1359 and 1589-2060 r/min",
        f"{found[0][1]:.1f}-{found[1][1]:.1f} and {found[2][1]:.1f}-{found[3][1]:.1f} r/min with the published time "
        f"scale of {published.model.time_scale:.1f} rad/s",
        graded(worst <= 1.0, False),
        f"the four pairs agree on one scale to {worst:.1f} r/min, but (15) gives {derived.model.time_scale:.4g} rad/s, "
        f"which puts Ω = 1 at {by_equation:.0f} r/min: the scale is a constant of a bench, not of the equations",
        {"worst_rpm": worst, "published": published.model.time_scale, "derived": derived.model.time_scale},
    )


def _claimed_chaotic(frequency: float) -> bool:
    return C2_WINDOW[0] <= frequency <= C2_WINDOW[1] or 1.515 <= frequency <= 1.975


def _exponent(seen: Seen) -> str:
    if seen.regime is None or seen.regime.lyapunov is None or seen.regime.lyapunov_error is None:
        return "unknown"
    return f"{seen.regime.lyapunov:.4f} ± {seen.regime.lyapunov_error:.4f}"
