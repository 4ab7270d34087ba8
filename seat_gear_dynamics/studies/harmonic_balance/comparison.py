"""Harmonic balance held against integration: the march settled at values of the parameter, going up and going down."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.studies.harmonic_balance.branch import Motion
from seat_gear_dynamics.studies.harmonic_balance.first_motion import system_at
from seat_gear_dynamics.studies.harmonic_balance.integration import FINE_STEPS, Recorded, difference, settle
from seat_gear_dynamics.studies.harmonic_balance.response_curve import ResponseCurve

Array = NDArray[np.float64]

DIRECTIONS = ("up", "down")
TRANSIENT = 1000
RECURS = 1e-3
"""Share of its range within which a motion must come back to count as periodic."""


@dataclass(frozen=True)
class Agreement:
    """One integrated motion beside the nearest stable one of the response curve."""

    value: float
    """Of the curve's parameter."""
    direction: str
    """`up` or `down`: where the integration came from."""
    period: int | None
    """Of the integrated motion in mesh periods; None where it does not repeat within the periods the curve covers."""
    motion: Motion | None
    """The nearest stable motion of the curve; None where it has none there."""
    difference: float | None
    """Largest distance in δ over a period of the curve's motion, over that motion's range; None without one."""

    @property
    def comparable(self) -> bool:
        """Whether both are periodic, the curve's with the period integration found."""
        return self.motion is not None and self.period == self.motion.orbit.balance.subharmonics


def compare(
    curve: ResponseCurve,
    values: Sequence[float],
    *,
    directions: Sequence[str] = DIRECTIONS,
    transient: int = TRANSIENT,
    target_steps: int = FINE_STEPS,
    progress: Callable[[float], None] | None = None,
) -> list[Agreement]:
    """Integrate at `values` upward, then downward, each from where the one before ended, and compare with `curve`.

    Each runs `transient` mesh periods in; the first of each way starts at rest. A value at which the motion blows up
    is left out, and the next starts at rest. The tolerance to expect is the run-in's: near a fold or a doubling
    motions settle slowly, and integration may then still be on its way.
    """
    rising = sorted(float(v) for v in values)
    found: list[Agreement] = []
    for direction in directions:
        if direction not in DIRECTIONS:
            raise ValueError(f"The direction is {direction!r}, expected one of {', '.join(DIRECTIONS)}.")
        way = rising if direction == "up" else rising[::-1]
        found += _one_way(curve, way, direction, transient, target_steps, progress)
    return found


def _one_way(
    curve: ResponseCurve,
    values: Sequence[float],
    direction: str,
    transient: int,
    target_steps: int,
    progress: Callable[[float], None] | None,
) -> Iterator[Agreement]:
    state: Array | None = None
    problem, most = curve.branches[0].balance, max(b.subharmonics for b in curve.branches)
    for value in values:
        at = system_at(curve.system, problem, value)
        try:
            recorded = settle(at, periods=2 * most, transient=transient, state=state, target_steps=target_steps)
        except DivergedError:
            state = None
            continue
        state = recorded.state
        if progress is not None:
            progress(value)
        yield _agreement(curve, value, direction, recorded, most)


def _agreement(curve: ResponseCurve, value: float, direction: str, recorded: Recorded, most: int) -> Agreement:
    period = next((n for n in range(1, most + 1) if recorded.repeats(n) < RECURS), None)
    near = [(difference(recorded, m.orbit), m) for m in curve.stable_at(value)]
    if not near:
        return Agreement(value, direction, period, None, None)
    apart, motion = min(near, key=lambda pair: pair[0])
    return Agreement(value, direction, period, motion, apart)
