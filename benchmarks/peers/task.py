"""What every integrator is asked for, and where its error is measured from.

The task: from rest, the state at the end of each of `periods` mesh periods, as sections and bifurcation diagrams take
it, at some frequencies beside each other. The error: the largest component of the last state, over all frequencies
that an integrator runs, from the converged end.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.peers.pair import Pair, harmonics, pair_of, slope, value
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import OperatingPoint, System
from seat_gear_dynamics.motion.integrators import EventLocating, integrate_time

Array = NDArray[np.float64]
Run = Callable[[], Array]
"""Integrates; returns the last states, (points, 2n)."""


@dataclass(frozen=True)
class Task:
    """Motions of one pair at several frequencies."""

    name: str
    train: GearTrain
    load: float
    frequencies: Array
    periods: int

    def pair(self, form: str) -> Pair:
        """Return the equations in one of their forms."""
        return pair_of(self.train, self.load, form=form)

    def some(self, count: int) -> "Task":
        """Return the task with `count` of its frequencies, spread evenly."""
        chosen = np.linspace(0, len(self.frequencies) - 1, count).round().astype(int)
        return Task(self.name, self.train, self.load, self.frequencies[chosen], self.periods)


class Peer(Protocol):
    """An integrator from outside."""

    @property
    def settings(self) -> Sequence[float]:
        """Its tolerances, the coarsest first."""

    def prepare(self, setting: float) -> Run:
        """Return a run at a setting; what is made once for many runs is made here."""


def tasks(train: GearTrain, *, points: int, periods: int) -> tuple[Task, ...]:
    """Return two motions of `train` at 600 N·m: in contact after the start, and rattling period-2 with impacts.

    That they are so holds for trains like the packaged one; `contact_changes` of the figures says what happened.
    """
    spread = np.linspace(0.99, 1.01, points)
    return tuple(
        Task(name, train, 600.0, frequency * spread, periods)
        for name, frequency in (("contact", 0.4), ("impacts", 1.0))
    )


def reference(task: Task) -> tuple[Array, Array]:
    """Return the converged ends of the whole train, (points, 24), and contact changes of P12 to there, (points,).

    By event-locating steps at a tolerance of 1e-13, whose only likeness to the lane kernel are the equations.
    """
    ends, changes = [], []
    for frequency in task.frequencies:
        system = System(task.train, OperatingPoint(float(frequency), task.load))
        span = (0.0, task.periods * 2 * pi / float(frequency))
        fine = EventLocating(tolerance=1e-13)
        found = integrate_time(system, span, system.static_state(), method=fine, every_step=False)
        ends.append(found.state)
        changes.append(float((found.changes.meshes == 0).sum()))
    return np.array(ends), np.array(changes)


def outside_reference(pair: Pair, frequency: float, periods: int) -> Array:
    """Return the end of one motion, (2n,), by SciPy's DOP853 at 1e-12, started anew at each change of contact.

    Nothing of the project's integrators is in it: a check of `reference`. Slow.
    """
    state, now, end = pair.rest, 0.0, periods * 2 * pi / frequency
    branch = int(np.sign(_gap(pair, frequency, now, state, 0)))
    while now < end:
        edges = [_edge(pair, frequency, flank) for flank in ((-1, 1) if branch == 0 else (branch,))]
        found = solve_ivp(
            _field(pair, frequency, branch), (now, end), state, method="DOP853", rtol=1e-12, atol=1e-13, events=edges
        )
        now, state = float(found.t[-1]), found.y[:, -1]
        if found.status == 1:
            hit = next(n for n, times in enumerate(found.t_events) if len(times))
            branch = ((-1, 1)[hit]) if branch == 0 else 0
            step = 1e-9  # off the edge, so that the next arc does not begin with its own event
            state = state + step * _field(pair, frequency, branch)(now, state)
            now += step
    return np.asarray(state)


def _turning(pair: Pair, angle: float) -> list[tuple[float, float]]:
    count = harmonics((pair.kappa, pair.error))
    return [(float(np.cos(n * angle)), float(np.sin(n * angle))) for n in range(1, count + 1)]


def _delta(pair: Pair, frequency: float, t: float, state: Array) -> float:
    return float(pair.closing @ state[: pair.coordinates]) - float(value(pair.error, _turning(pair, frequency * t)))


def _gap(pair: Pair, frequency: float, t: float, state: Array, branch: int) -> float:
    """Return how far δ is beyond the backlash; 0 within it."""
    delta = _delta(pair, frequency, t, state)
    return delta - float(np.clip(delta, -pair.half_backlash, pair.half_backlash))


def _edge(pair: Pair, frequency: float, flank: int) -> Callable[[float, Array], float]:
    def edge(t: float, state: Array) -> float:
        return _delta(pair, frequency, t, state) - flank * pair.half_backlash

    edge.terminal = True  # type: ignore[attr-defined]  # as solve_ivp is told what ends an arc
    return edge


def _field(pair: Pair, frequency: float, branch: int) -> Callable[[float, Array], Array]:
    n = pair.coordinates

    def field(t: float, state: Array) -> Array:
        turning = _turning(pair, frequency * t)
        delta = float(pair.closing @ state[:n]) - value(pair.error, turning)
        rate = float(pair.closing @ state[n:]) - frequency * slope(pair.error, turning)
        beyond = (delta - branch * pair.half_backlash) if branch else 0.0
        force = value(pair.kappa, turning) * beyond + pair.mesh_damping * rate
        pushed = pair.drive - pair.stiffness * state[:n] - pair.damping * state[n:] - pair.gain * force
        return np.concatenate([state[n:], pushed])

    return field
