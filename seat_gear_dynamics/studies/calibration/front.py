"""The trade-off between claims: the candidates that no other beats in every claim at once."""

from collections.abc import Sequence

from seat_gear_dynamics.studies.calibration.search import Candidate


def front(candidates: Sequence[Candidate], claims: Sequence[str]) -> list[Candidate]:
    """Return the candidates that are not dominated in the scores of `claims`, best cost first.

    One dominates another where it scores at least as well in each claim and better in one. Raises ValueError for an
    empty list of claims.
    """
    if not claims:
        raise ValueError("No claims were given to trade against each other; name at least one.")
    points = [tuple(c.scores[claim] for claim in claims) for c in candidates]
    kept = [
        candidate
        for candidate, own in zip(candidates, points, strict=True)
        if not any(_dominates(other, own) for other in points)
    ]
    return sorted(kept, key=lambda c: c.cost)


def _dominates(other: tuple[float, ...], own: tuple[float, ...]) -> bool:
    return all(a >= b for a, b in zip(other, own, strict=True)) and other != own
