"""Tracing a branch of motions: the continuation with stability at each point, and bifurcations located in between."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.studies.harmonic_balance.balance import Balance
from seat_gear_dynamics.studies.harmonic_balance.branch import BIFURCATIONS, Bifurcation, Branch, Motion
from seat_gear_dynamics.studies.harmonic_balance.continuation import Arc, Point, follow, step_along
from seat_gear_dynamics.studies.harmonic_balance.fourier import amplitudes
from seat_gear_dynamics.studies.harmonic_balance.newton import NoSolutionError
from seat_gear_dynamics.studies.harmonic_balance.orbit import Orbit
from seat_gear_dynamics.studies.harmonic_balance.stability import NEUTRAL

Array = NDArray[np.float64]

MOST_POINTS = 3000
_REFINEMENTS = 30
_FLAT = 1e-8  # of scaled arc: closer a bifurcation is not located
_CLOSED = 1e-3  # scaled distance from the first point at which a branch counts as closed
_BESIDE = 0.05  # scaled distance from a fold within which a multiplier at +1 is the fold's
_COMPLEX = 1e-3  # imaginary part, over the size, from which on a multiplier counts as one of a pair


@dataclass(frozen=True)
class Range:
    """The parameter range of a branch and the arc to follow it with."""

    low: float
    high: float
    arc: Arc
    most_points: int = MOST_POINTS

    def __post_init__(self) -> None:
        if not self.low < self.high:
            raise ValueError(f"The range is {self.low!r} to {self.high!r}, expected two numbers, the lower one first.")


def trace(balance: Balance, first: Point, within: Range, progress: Callable[[float], None] | None = None) -> Branch:
    """Follow the branch through `first` along its tangent and return it with its bifurcations.

    It ends where the parameter leaves the range, where it closes, where a motion of several mesh periods shrinks into
    one of fewer, where Newton's method finds nothing more, or after `most_points`. `progress` gets each parameter.
    """
    start = _motion(balance, first)
    motions, bifurcations, ended = [start], list[Bifurcation](), "range"
    points = follow(balance, first, within.low, within.high, within.arc)
    while True:
        try:
            point = next(points, None)
        except NoSolutionError:
            ended = "lost"
            break
        if point is None:
            break
        motion = _motion(balance, point)
        if _halving(motions[-1], motion) < 0:
            motions.append(_last_before_halving(motions[-1], motion, within.arc))
            ended = "halved"
            break
        found = list(_between(motions[-1], motion, within.arc))
        bifurcations += found
        motions += [b.motion for b in found] + [motion]
        if progress is not None:
            progress(motion.parameter)
        if len(motions) > 3 and _closes(motions, within.arc):
            ended = "closed"
            break
        if len(motions) >= within.most_points:
            ended = "points"
            break
    return Branch(balance, tuple(motions), tuple(_told_apart(bifurcations, within.arc)), ended)


def _motion(balance: Balance, point: Point) -> Motion:
    return Motion(Orbit(balance, balance.at(point.parameter), point.unknowns), point)


def _between(a: Motion, b: Motion, arc: Arc) -> Iterator[Bifurcation]:
    """Yield the bifurcations between two neighbours, in their order along the branch.

    A turn of the parameter is a fold; a change in the number of unstable multipliers is what its multiplier says. Two
    changes within one step that undo each other are not seen.
    """
    found: list[tuple[float, Bifurcation]] = []
    turned = a.point.tangent[-1] * b.point.tangent[-1] < 0
    if turned:
        found += _located(a, b, arc, lambda m: float(m.point.tangent[-1]), "fold")
    if a.unstable != b.unstable:
        k = max(a.unstable, b.unstable) - 1
        found += [
            (place, event)
            for place, event in _located(a, b, arc, lambda m: float(abs(m.multipliers[k]) - 1 - NEUTRAL), None, k)
            if not (turned and event.kind == "branch point")
        ]
    for _, event in sorted(found, key=lambda pair: pair[0]):
        yield event


def _located(
    a: Motion, b: Motion, arc: Arc, measure: Callable[[Motion], float], kind: str | None, index: int = 0
) -> list[tuple[float, Bifurcation]]:
    """Return the zero of `measure` between two motions as (arc from a, bifurcation)."""
    at, met = _in_between(a, b, arc)
    place = _zero(lambda place: measure(at(place)), *met)
    multipliers = met[place].multipliers
    near = multipliers[np.argmin(np.abs(multipliers - 1))] if kind == "fold" else multipliers[index]
    return [(place, Bifurcation(kind or _kind(complex(near)), met[place], complex(near)))]


def _in_between(a: Motion, b: Motion, arc: Arc) -> tuple[Callable[[float], Motion], dict[float, Motion]]:
    """Return the motion as a function of arc from `a`, solved where it is asked for, and those that are known."""
    balance = a.orbit.balance
    begin = arc.scaled(a.point.unknowns, a.point.parameter)
    chord = arc.scaled(b.point.unknowns, b.point.parameter) - begin
    length = float(chord @ a.point.tangent)
    met: dict[float, Motion] = {0.0: a, length: b}

    def at(place: float) -> Motion:
        if place not in met:
            guess = begin + chord * (place / length)
            met[place] = _motion(balance, step_along(balance, a.point, place, arc, guess)[0])
        return met[place]

    return at, met


def _zero(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the argument nearest to a zero among those where the function is not negative.

    False position in the Illinois form, with a bisection wherever two steps did not halve the bracket: the size of a
    multiplier that comes out from behind neutral ones has a corner there. Where the branch cannot be met in between,
    the nearer end of what has been bracketed.
    """
    values = {low: function(low), high: function(high)}
    at_low, at_high, moved, widths = values[low], values[high], 0, [high - low] * 2
    for _ in range(_REFINEMENTS):
        if at_low == at_high or high - low < _FLAT or min(abs(v) for v in values.values() if v >= 0) < _FLAT:
            break
        place = high - at_high * (high - low) / (at_high - at_low)
        if high - low > widths[-2] / 2:
            place = (low + high) / 2
        try:
            value = values[place] = function(place)
        except NoSolutionError:
            break
        widths.append(high - low)
        if (value > 0) == (at_high > 0):
            high, at_high = place, value
            at_low, moved = (at_low / 2 if moved > 0 else at_low), 1
        else:
            low, at_low = place, value
            at_high, moved = (at_high / 2 if moved < 0 else at_high), -1
    return min((place for place in values if values[place] >= 0), key=lambda place: values[place])


def _kind(multiplier: complex) -> str:
    if abs(multiplier.imag) > _COMPLEX * abs(multiplier):
        return BIFURCATIONS[3]
    return BIFURCATIONS[2] if multiplier.real < 0 else BIFURCATIONS[1]


def _told_apart(events: list[Bifurcation], arc: Arc) -> Iterator[Bifurcation]:
    """Yield the bifurcations but for branch points beside a fold, whose own multiplier passed the margin a step off."""
    folds = [arc.scaled(e.motion.point.unknowns, e.parameter) for e in events if e.kind == "fold"]
    for event in events:
        place = arc.scaled(event.motion.point.unknowns, event.parameter)
        if event.kind != "branch point" or all(np.linalg.norm(place - fold) > _BESIDE for fold in folds):
            yield event


def _halving(before: Motion, after: Motion) -> float:
    """Return the least product, over the primes p of n, of the parts of two motions that n/p mesh periods do not have.

    It is negative where such a part went through zero between them: there the motion was one of n/p mesh periods.
    """
    n = after.orbit.balance.subharmonics
    a, b = amplitudes(before.orbit.coefficients), amplitudes(after.orbit.coefficients)
    orders = np.arange(len(a))
    primes = [p for p in range(2, n + 1) if n % p == 0 and all(p % d for d in range(2, p))]
    return min((float((a[orders % p != 0].conj() @ b[orders % p != 0]).real) for p in primes), default=1.0)


def _last_before_halving(a: Motion, b: Motion, arc: Arc) -> Motion:
    """Return the motion between two neighbours that is nearest to having the smaller period and still has not."""
    at, met = _in_between(a, b, arc)
    return met[_zero(lambda place: _halving(a, at(place)), *met)]


def _closes(motions: list[Motion], arc: Arc) -> bool:
    """Return whether the last step passed the first point in the direction the branch was begun."""
    first, before, last = (m.point for m in (motions[0], motions[-2], motions[-1]))
    origin = arc.scaled(first.unknowns, first.parameter)
    a, b = (arc.scaled(p.unknowns, p.parameter) - origin for p in (before, last))
    if not (a @ first.tangent < 0 <= b @ first.tangent and last.tangent @ first.tangent > 0):
        return False
    along = (b - a) / np.linalg.norm(b - a)
    miss = a - (a @ along) * along
    return bool(np.linalg.norm(miss) < max(_CLOSED, 0.1 * float(np.linalg.norm(b - a))))
