"""Running Table 3's conditions: the force histories that ADAMS would write, and their statistics.

Here the full static load acts (5652 N in P12 for 300 N·m), as Table 4's averages show; the lumped model's force is
`load_scale` times that.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import inf, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.studies.contact_verification.conditions import CONDITIONS, RUNNING_TIME, Condition
from seat_gear_dynamics.studies.contact_verification.impact import Contact
from seat_gear_dynamics.studies.contact_verification.line_of_action import line_of_action
from seat_gear_dynamics.studies.contact_verification.march import (
    DIVERGED,
    SAMPLE_COLUMNS,
    Accuracy,
    march,
)
from seat_gear_dynamics.studies.contact_verification.readings import Assumptions, contacts
from seat_gear_dynamics.studies.contact_verification.rigid_train import Drive, Train

Array = NDArray[np.float64]

SAMPLE_RATE = 1000.0
"""Samples per second: 5 s in 5000 steps, a usual ADAMS output; the paper does not give its own."""
SETTLED_FROM = 1.0
"""Time from which on the start is over, s: ten default speed ramps."""
TOLERANCE = 1e-5
"""Error of a step over the damping depth; at 1e-6 the start-up peaks change by less than 0.1 %."""
_STEPS_PER_MESH_PERIOD = 200
_FIRST_STEP = 1e-8  # s


@dataclass(frozen=True)
class Statistics:
    """Of the driving flanks' normal force over a stretch of time, N."""

    minimum: float
    maximum: float
    mean: float
    rms: float
    contact_loss: float
    """Share of the time at force 0, 0 to 1."""

    @property
    def deviation(self) -> float:
        """Standard deviation, N."""
        return sqrt(max(self.rms**2 - self.mean**2, 0.0))

    @classmethod
    def of(cls, force: Array) -> "Statistics":
        """Return those of samples, shape (n,); raises ValueError for none."""
        if not force.size:
            raise ValueError("There are no force samples to take statistics of; run for longer.")
        rms = float(np.sqrt(np.mean(force**2)))
        return cls(
            float(force.min()),
            float(force.max()),
            float(force.mean()),
            rms,
            float(np.count_nonzero(force <= 0)) / force.size,
        )

    @classmethod
    def from_window(cls, window: Array) -> "Statistics":
        """Return those of a window of the march, shape (6,), which counts every step that it made."""
        time = window[0]
        mean, rms = float(window[1] / time), float(np.sqrt(window[2] / time))
        return cls(float(window[3]), float(window[4]), mean, rms, float(window[5] / time))


@dataclass(frozen=True)
class ForceHistory:
    """Samples of a run, each of shape (n,)."""

    time: Array
    """s"""
    force: Array
    """Normal force on the driving flanks of P12, all pairs together, N."""
    second_force: Array
    """The same of P34, N."""
    back_force: Array
    """Normal force on the other flanks of P12, N; above 0 the mesh is jammed, or rattles."""
    input_torque: Array
    """That s1's motion needs, N·m."""


@dataclass(frozen=True)
class ConditionRun(Plottable, figure="contact_force:plot_condition", table="motions:condition_table"):
    """One condition, run."""

    condition: Condition
    assumptions: Assumptions
    static: float
    """What the static chain gives for P12 at the full load, N."""
    mesh_period: float
    """Of P12, s; infinite at standstill."""
    history: ForceHistory
    settled_from: float
    """s"""
    start: Statistics
    """Over every integration step before `settled_from`, the start-up impact included."""
    settled: Statistics
    """Over every integration step from `settled_from` on."""

    @property
    def sampled(self) -> Statistics:
        """Of the samples from `settled_from` on: what a table of ADAMS' output without the start holds."""
        return Statistics.of(self.history.force[self.history.time >= self.settled_from])

    @property
    def sampled_whole(self) -> Statistics:
        """Of all samples, the start included; an impact shorter than the sample interval may fall between two."""
        return Statistics.of(self.history.force)

    @property
    def peak(self) -> float:
        """Largest force of the whole run, whatever the sampling, N."""
        return max(self.start.maximum, self.settled.maximum)


def rigid_train(train: GearTrain, backlash: float, assumptions: Assumptions) -> Train:
    """Return the rigid bodies and contacts with `backlash`, m, on P12 and none on P34, as section 4.1 has it.

    Inertias are Table 1's (ADAMS computes its own from the solids); s2 and s3 are one body. Raises ValueError as
    `line_of_action` and `contacts` do.
    """
    first, second = train.meshes
    laws = contacts(train, assumptions)
    lines = (
        line_of_action(first, backlash, corner=assumptions.corner),
        line_of_action(second, 0.0, corner=assumptions.corner),
    )
    return Train(*lines, *laws, first.driven.inertia + second.driver.inertia, second.driven.inertia)


def run_condition(
    train: GearTrain,
    condition: Condition,
    assumptions: Assumptions | None = None,
    *,
    duration: float = RUNNING_TIME,
    sample_rate: float = SAMPLE_RATE,
    settled_from: float = SETTLED_FROM,
    tolerance: float = TOLERANCE,
) -> ConditionRun:
    """Run one condition from rest for `duration`, s, and return its history and statistics.

    `assumptions` are the defaults where None. s1's teeth carry the eccentricity (the paper does not say which gear's).
    Raises ValueError for values that are no run, DivergedError where the solution is lost.
    """
    if not 0 < settled_from < duration < inf:
        raise ValueError(
            f"The run of {duration!r} s is to settle by {settled_from!r} s; expected 0 < settled_from < duration."
        )
    assumed = assumptions or Assumptions()
    samples = _samples(duration, sample_rate)
    split = int(np.searchsorted(samples[:, 0], settled_from))
    if split + 1 >= len(samples):
        raise ValueError(f"No sample falls between {settled_from!r} and {duration!r} s; run for longer.")
    start, settled = _march(train, condition, assumed, [samples[: split + 1], samples[split + 1 :]], tolerance)
    static, _ = train.static_forces(condition.load)
    period = _mesh_period(train, condition)
    return ConditionRun(condition, assumed, static, period, _history(samples), settled_from, start, settled)


def start_up(
    train: GearTrain,
    condition: Condition,
    assumptions: Assumptions | None = None,
    *,
    duration: float = 5e-4,
    sample_rate: float = 1e6,
    tolerance: float = TOLERANCE,
) -> ForceHistory:
    """Return the first moments of a condition, finely sampled: how teeth close the backlash and hit.

    Raises as `run_condition`.
    """
    samples = _samples(duration, sample_rate)
    _march(train, condition, assumptions or Assumptions(), [samples], tolerance)
    return _history(samples)


def run_conditions(
    train: GearTrain,
    numbers: Iterable[int] = tuple(CONDITIONS),
    assumptions: Assumptions | None = None,
    *,
    progress: Callable[[int], None] | None = None,
) -> dict[int, ConditionRun]:
    """Run conditions of Table 3 by number and return them by number; `progress` is told each one that is done.

    Raises KeyError for a number that Table 3 does not have, else as `run_condition`.
    """
    runs: dict[int, ConditionRun] = {}
    for number in numbers:
        runs[number] = run_condition(train, CONDITIONS[number], assumptions)
        if progress is not None:
            progress(number)
    return runs


def _samples(duration: float, sample_rate: float) -> Array:
    if not (0 < duration < inf and 0 < sample_rate < inf):
        raise ValueError(
            f"A run of {duration!r} s with {sample_rate!r} samples a second has no samples: give both above 0."
        )
    count = int(duration * sample_rate + 0.5) + 1
    samples = np.zeros((count, len(SAMPLE_COLUMNS)))
    samples[:, 0] = np.arange(count) / sample_rate
    return samples


def _history(samples: Array) -> ForceHistory:
    return ForceHistory(*(np.ascontiguousarray(column) for column in samples.T))


def _march(
    train: GearTrain, condition: Condition, assumptions: Assumptions, parts: list[Array], tolerance: float
) -> list[Statistics]:
    """Fill the samples of consecutive `parts` of a run and return the statistics of P12 over each."""
    bodies = rigid_train(train, condition.backlash, assumptions)
    drive = _drive(condition, assumptions)
    accuracy = _accuracy(bodies, _mesh_period(train, condition), tolerance)
    lead = bodies.first.half_backlash / bodies.first.driven_radius if assumptions.apart else 0.0
    state = np.array([lead, lead * bodies.second.driver_radius / bodies.second.driven_radius, 0.0, 0.0])
    clock = np.array([0.0, _FIRST_STEP])
    found = []
    for samples in parts:
        windows = np.tile(np.array([0.0, 0.0, 0.0, inf, -inf, 0.0]), (2, 1))
        if march(bodies, drive, accuracy, state, clock, samples, windows) == DIVERGED:
            raise DivergedError(f"The solution of {condition.name} was lost after {clock[0]:g} s: lower the tolerance.")
        found.append(Statistics.from_window(windows[0]))
    return found


def _drive(condition: Condition, assumptions: Assumptions) -> Drive:
    values = (condition.speed, assumptions.speed_ramp, condition.load, assumptions.load_ramp, condition.eccentricity)
    if not all(0 <= value < inf for value in values):
        raise ValueError(
            f"Speed, its ramp, load, its ramp and eccentricity are {values}; expected finite numbers of at least 0."
        )
    return Drive(*values)


def _mesh_period(train: GearTrain, condition: Condition) -> float:
    rate = train.meshes[0].driver.teeth * condition.speed / (2 * pi)
    return 1 / rate if rate else inf


def _accuracy(bodies: Train, mesh_period: float, tolerance: float) -> Accuracy:
    """Return errors of `tolerance` damping depths on arcs, times the contact's natural frequency on their rates."""
    if not 0 < tolerance < 1:
        raise ValueError(f"The tolerance is {tolerance!r}, expected a number between 0 and 1.")
    contact = bodies.first_contact
    arc = tolerance * contact.depth
    frequency = contact_frequency(contact, bodies.middle_inertia / bodies.first.driven_radius**2)
    return Accuracy(arc, arc * frequency, mesh_period / _STEPS_PER_MESH_PERIOD)


def contact_frequency(contact: Contact, mass: float) -> float:
    """Return the natural frequency of `mass`, kg, on a contact penetrated to its damping depth, rad/s."""
    slope = contact.exponent * contact.stiffness * contact.depth ** (contact.exponent - 1)
    return sqrt(slope / mass)
