"""The response curve of P12: branches of periodic motion over a parameter, their folds, and where motions coexist."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion import System
from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.studies.harmonic_balance.balance import Balance, balance
from seat_gear_dynamics.studies.harmonic_balance.branch import (
    Bifurcation,
    Branch,
    Motion,
    joined,
    lies_on,
    motions_at,
)
from seat_gear_dynamics.studies.harmonic_balance.continuation import Arc, Point, start
from seat_gear_dynamics.studies.harmonic_balance.doubling import branch_off
from seat_gear_dynamics.studies.harmonic_balance.first_motion import first_motion, system_at
from seat_gear_dynamics.studies.harmonic_balance.integration import Recorded, coefficients, settle
from seat_gear_dynamics.studies.harmonic_balance.newton import NoSolutionError
from seat_gear_dynamics.studies.harmonic_balance.pair import pair
from seat_gear_dynamics.studies.harmonic_balance.tracing import MOST_POINTS, Range, trace

Array = NDArray[np.float64]

HARMONICS = 32
"""Of the mesh frequency: with contact loss the packaged pair's δ is then exact to about 1e-5 of its range."""
SCALE = 0.2
"""b_c of change in the harmonics that counts as one step of arc."""
STEPS = 400
"""Longest steps across the range: two changes of stability that are closer than one of them may be missed."""

STARTS = 40
"""Integrations from rest across the range that look for motions of several mesh periods."""

_SCAN_PERIODS = 600
_RECURS = 1e-3
_NARROW = 1e-4


@dataclass(frozen=True)
class ResponseCurve(Plottable, figure="response_curve:plot_curve", table="studies:response_curve_table"):
    """What the pair does over a range of one parameter, as far as it was followed."""

    system: System
    parameter: str
    low: float
    high: float
    branches: tuple[Branch, ...]

    @property
    def bifurcations(self) -> tuple[Bifurcation, ...]:
        """Of all branches, in their order."""
        return tuple(b for branch in self.branches for b in branch.bifurcations)

    @property
    def folds(self) -> tuple[Bifurcation, ...]:
        """The turning points, where a motion jumps."""
        return tuple(b for b in self.bifurcations if b.kind == "fold")

    def coexistence(self) -> list[tuple[float, float]]:
        """Return the parameter intervals in which two or more stable motions were found, lowest first.

        Those narrower than 1/10000 of the range are left out: bifurcations are not located more closely.
        """
        edges: list[tuple[float, int]] = []
        for branch in self.branches:
            for first, last in branch.runs():
                low, high = sorted((branch.motions[first].parameter, branch.motions[last].parameter))
                edges += [(low, 1), (high, -1)]
        least = _NARROW * (self.high - self.low)
        return [(low, high) for low, high in _overlaps(edges) if high - low > least]

    def stable_at(self, value: float) -> list[Motion]:
        """Return the stable motions at one value of the parameter, each solved there."""
        return [m for m in self.motions_at(value) if m.stable]

    def motions_at(self, value: float) -> list[Motion]:
        """Return all motions followed that exist at one value of the parameter, stable or not, each solved there."""
        return [motion for branch in self.branches for motion in motions_at(branch, value)]


def response_curve(
    system: System,
    low: float,
    high: float,
    *,
    parameter: str = "frequency",
    harmonics: int = HARMONICS,
    subharmonics: int = 1,
    starts: int = STARTS,
    most_points: int = MOST_POINTS,
    progress: Callable[[float], None] | None = None,
) -> ResponseCurve:
    """Follow the periodic motions of P12 over `parameter` from `low` to `high`, through their folds.

    `parameter` is frequency (Ω), load (T4, N·m), damping_ratio (ξ of the mesh) or backlash (m); the others are the
    system's own. With `subharmonics` n above 1 also the motions whose period is one of the divisors of n, in mesh
    periods: those born by period doubling, and those that integrations from rest at `starts` values across the range
    settle on.

    What it finds is what is connected to its starts, a motion at either end of the range among them; others there may
    be are not found. It is P12 alone: the train that a shaft couples is not covered. Raises ValueError for
    impossible values and where a shaft couples the pairs, NoSolutionError where no motion is found to start from.
    """
    folded, conditions = pair(system)
    conditions.with_value(parameter, low), conditions.with_value(parameter, high)
    if harmonics < 1 or subharmonics < 1:
        raise ValueError(
            f"{harmonics} harmonics and {subharmonics} subharmonics were asked for, expected 1 or more of both."
        )
    within = Range(low, high, _arc(low, high), most_points)
    problem = balance(folded, conditions, harmonics=harmonics, parameter=parameter)
    branches = _from_the_ends(system, problem, within, progress)
    seen = _scan(system, problem, within, subharmonics, starts) if subharmonics > 1 else []
    for n in range(2, subharmonics + 1):
        if subharmonics % n == 0:
            branches += _doubled(branches, n, within, progress)
            branches += _settled(seen, branches, n, harmonics, within, progress)
    return ResponseCurve(system, parameter, low, high, tuple(branches))


def _from_the_ends(
    system: System, problem: Balance, within: Range, progress: Callable[[float], None] | None
) -> list[Branch]:
    """Return the branch begun at the range's low end, and where it does not reach the high end the one begun there."""
    low, high, arc = within.low, within.high, within.arc
    first = trace(problem, start(problem, first_motion(system, problem, low), low, arc), within, progress)
    if first.parameters[-1] == high:
        return [first]
    with suppress(NoSolutionError, DivergedError):
        point = start(problem, first_motion(system, problem, high), high, arc, upward=False)
        if not lies_on(first, point):
            return [first, trace(problem, point, within, progress)]
    return [first]


def _arc(low: float, high: float) -> Arc:
    return Arc(SCALE, (high - low) / STEPS)


def _doubled(branches: list[Branch], n: int, within: Range, progress: Callable[[float], None] | None) -> list[Branch]:
    """Return the branches of period n born by doubling on the branches of half of it, each found once."""
    found: list[Branch] = []
    for branch in branches:
        for event in branch.bifurcations:
            if 2 * branch.subharmonics != n or event.kind != "period doubling":
                continue
            if any(_ends_at(other, event, within.arc) for other in found):
                continue
            try:
                problem, point = branch_off(event, within.arc)
            except NoSolutionError:
                continue
            found.append(trace(problem, point, within, progress))
    return found


def _ends_at(branch: Branch, event: Bifurcation, arc: Arc) -> bool:
    """Return whether a branch shrank into the motion that doubles in `event`, within a step."""
    last = branch.motions[-1].point
    doubled = branch.balance.basis.resampled(event.motion.orbit.coefficients, 2)
    apart = arc.scaled(last.unknowns, last.parameter) - arc.scaled(doubled, event.parameter)
    return branch.ended == "halved" and float(np.linalg.norm(apart)) < arc.longest


def _scan(system: System, problem: Balance, within: Range, most: int, starts: int) -> list[tuple[float, Recorded]]:
    """Return what integrations from rest settle on at `starts` values, each over twice `most` mesh periods."""
    found: list[tuple[float, Recorded]] = []
    for value in np.linspace(within.low, within.high, starts + 2)[1:-1]:
        at = system_at(system, problem, float(value))
        with suppress(DivergedError):
            found.append((float(value), settle(at, periods=2 * most, transient=_SCAN_PERIODS, target_steps=1)))
    return found


def _settled(
    seen: list[tuple[float, Recorded]],
    branches: list[Branch],
    n: int,
    harmonics: int,
    within: Range,
    progress: Callable[[float], None] | None,
) -> list[Branch]:
    """Return the branches of period n that integrated motions lie on, followed both ways, each found once."""
    model = branches[0].balance
    problem = balance(model.pair, model.conditions, harmonics=harmonics, subharmonics=n, parameter=model.parameter)
    found: list[Branch] = []
    for value, recorded in seen:
        if not _has_period(recorded.repeats, n):
            continue
        try:
            point = start(problem, coefficients(recorded, problem), value, within.arc)
        except NoSolutionError:
            continue
        if any(lies_on(other, point) for other in [*branches, *found]):
            continue
        forward = trace(problem, point, within, progress)
        if forward.ended != "closed":
            back = Point(point.unknowns, point.parameter, -point.tangent)
            forward = joined(trace(problem, back, within, progress), forward)
        found.append(forward)
    return found


def _has_period(repeats: Callable[[int], float], n: int) -> bool:
    """Return whether a motion repeats after n periods and after no fewer."""
    return repeats(n) < _RECURS and all(repeats(m) > 10 * _RECURS for m in range(1, n) if n % m == 0)


def _overlaps(edges: list[tuple[float, int]]) -> list[tuple[float, float]]:
    """Return where at least two of the intervals, given as (end, +1 or -1), lie over each other."""
    found: list[tuple[float, float]] = []
    depth, begin = 0, 0.0
    for place, change in sorted(edges, key=lambda edge: (edge[0], edge[1])):
        if change > 0 and depth == 1:
            begin = place
        if change < 0 and depth == 2 and place > begin:
            found.append((begin, place))
        depth += change
    return found
