"""C15: what the paper announces and does not show, a harmonic balance and a Taguchi study."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from seat_gear_dynamics.motion import System
from seat_gear_dynamics.studies.harmonic_balance import Agreement, ResponseCurve, compare, response_curve
from seat_gear_dynamics.studies.reproduction.claim import Claim
from seat_gear_dynamics.studies.taguchi import Finding, Study, vibration_and_impact

LOW, HIGH = 0.2, 1.2
"""Of the response curve, Ω: below the wide chaotic band."""
COMPARED = 6
LOAD = 600.0


@dataclass(frozen=True, eq=False)
class Announced:
    """Both studies."""

    curve: ResponseCurve
    agreements: tuple[Agreement, ...]
    study: Study


def announced(system: System, progress: Callable[[int, int], None]) -> Announced:
    """Return a response curve of P12 at 600 N·m with its comparison, and the Taguchi study at the system's point."""
    curve = response_curve(system.at(frequency=LOW, load=LOAD), LOW, HIGH, subharmonics=2)
    progress(1, 3)
    agreements = compare(curve, [float(f) for f in np.linspace(LOW, HIGH, COMPARED)])
    progress(2, 3)
    study = vibration_and_impact(system)
    progress(3, 3)
    return Announced(curve, tuple(agreements), study)


def announced_claim(found: Announced) -> Claim:
    """C15: announced in the introduction, and not shown."""
    held = [a.difference for a in found.agreements if a.comparable and a.difference is not None]
    worst = max(held) if held else float("nan")
    folds, twice = len(found.curve.folds), found.curve.coexistence()
    places = ", ".join(f"{low:.3f}-{high:.3f}" for low, high in twice) or "nowhere"
    taguchi = [_told(finding) for finding in found.study.findings.values()]
    return Claim(
        "C15",
        "announced in the introduction",
        "harmonic-balance response curves and a Taguchi multi-factor analysis, of which the paper shows nothing",
        f"response curve of P12 on Ω {LOW}-{HIGH} with {folds} folds, coexisting stable motions on {places}, within "
        f"{worst:.1e} of integration at {len(held)} motions; Taguchi, {'; '.join(taguchi)}",
        "partly",
        "both studies are done here, but the paper gives no figure to hold them against",
        {"worst_difference": worst, "folds": folds, "coexistence": twice},
    )


def _told(finding: Finding) -> str:
    if finding.analysis is None:
        return f"{finding.response}: {finding.reason}"
    strongest = sorted(finding.analysis.factors, key=lambda source: -source.contribution)[:3]
    named = ", ".join(f"{s.name} {s.contribution:.0%}" for s in strongest)
    confirmed = {True: "within", False: "outside", None: "without"}[finding.within]
    return f"{finding.response}: {named}; confirmation run {confirmed} its interval"
