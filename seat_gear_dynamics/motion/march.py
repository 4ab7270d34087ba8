"""A motion under way: the state of one gear train, advanced through piecewise-linear inputs by the compiled march."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import kernel, steps
from seat_gear_dynamics.motion.coefficients import coefficients, static_state
from seat_gear_dynamics.motion.system import STATE_NAMES
from seat_gear_dynamics.motion.tables import LEVELS, TARGET_STEPS, tables

Array = NDArray[np.float64]

LONGEST_STEP = 0.1
"""Longest step, in units of τ; the stiffest mode of the packaged train turns by less than 0.2 rad in it."""
WHOLE_NAMES: tuple[str, ...] = (
    *STATE_NAMES,
    *(f"tangent/{name}" for name in STATE_NAMES),
    *("tau", "phase/unspent"),
    *("phase/place", "tangent/age"),
    *("growth/s1_s2", "growth/s3_s4"),
)
"""What `March.whole` holds: state, tangent, clock, place on the phase grid, growth of the tangent's halves."""
_SECTION_ROOM = 4096  # section points a call may give before the march stops to have them read


class DivergedError(ArithmeticError):
    """The solution left every physical bound; the text says at what drive."""


@dataclass(frozen=True)
class Inputs:
    """What drives the model at one moment: dimensionless frequency (signed) and load T4, N·m."""

    frequency: float
    load: float


@dataclass(frozen=True)
class Window:
    """Dimensionless force statistics of one mesh over a stretch of time; merge to get those of a longer stretch."""

    duration: float = 0.0
    """Time covered, units of τ."""
    sum: float = 0.0
    sum_of_squares: float = 0.0
    minimum: float = inf
    maximum: float = -inf
    separated: float = 0.0
    """Time out of contact, units of τ."""

    @property
    def mean(self) -> float:
        """Time mean; NaN for an empty window."""
        return self.sum / self.duration if self.duration else float("nan")

    @property
    def rms(self) -> float:
        """Root mean square; NaN for an empty window."""
        return sqrt(self.sum_of_squares / self.duration) if self.duration else float("nan")

    @property
    def contact_loss(self) -> float:
        """Share of the time out of contact, 0 to 1; NaN for an empty window."""
        return self.separated / self.duration if self.duration else float("nan")

    def merged(self, other: "Window") -> "Window":
        """Return the statistics of this window followed by `other`."""
        return Window(
            self.duration + other.duration,
            self.sum + other.sum,
            self.sum_of_squares + other.sum_of_squares,
            min(self.minimum, other.minimum),
            max(self.maximum, other.maximum),
            self.separated + other.separated,
        )


class March:
    """The gear train in motion, from rest at static deflection.

    `advance` takes the motion through one piece of linear inputs; it may be called any number of times, and how time
    is cut into calls changes nothing but rounding in the interpolation of the inputs. A step that starts before the
    end is made whole, so the motion is ahead of the last input by less than one step.
    """

    def __init__(
        self,
        train: GearTrain,
        *,
        load: float = 0.0,
        target_steps: int = TARGET_STEPS,
        longest_step: float = LONGEST_STEP,
    ) -> None:
        c, t = coefficients(train), tables(train, target_steps=target_steps)
        self.train = train
        self.force_unit = c.force_unit
        self.length_unit = c.length_unit
        self._equations = kernel.Equations(
            c.stiffness,
            c.damping,
            c.direction,
            c.reaction,
            c.drive,
            c.mesh_damping,
            c.half_backlash,
            c.shaft_direction,
            c.shaft_reaction,
            c.shaft_stiffness,
            c.shaft_damping,
            train.shaft.couples,
            c.backlash_in_torsion,
            c.damping_in_contact_only,
        )
        self._grid = kernel.Grid(
            t.first,
            t.second,
            t.base,
            t.base_second,
            LEVELS,
            t.cycle,
            longest_step,
            bool(c.eccentricity.any()),
            c.eccentricity,
            c.eccentricity_phase,
            c.shaft_turns,
        )
        self.steps_per_period = t.base
        self.restart(load)

    def restart(self, load: float, *, tau: float = 0.0) -> None:
        """Put the train at rest at static deflection under `load` (N·m), mesh phase 0, dimensionless time `tau`."""
        self._y = static_state(self.train, load)
        # Any direction does for a largest exponent; a fixed one keeps every run the same.
        self._z = np.tile(np.array([0.5, 0.3, 0.7, -0.2, 0.4, 0.6]), 4)
        self._clock = np.array([tau, 0.0])
        self._place = np.zeros(2, dtype=np.int64)
        self._growth = np.zeros(2)

    @property
    def compiled(self) -> tuple[kernel.Equations, kernel.Grid]:
        """The train as the compiled march takes it, for compiled code that steps on its own; arrays are not copies."""
        return self._equations, self._grid

    @property
    def tau(self) -> float:
        """Dimensionless time reached."""
        return float(self._clock[0])

    @property
    def state(self) -> Array:
        """A copy of the state, shape (24,), in the order of STATE_NAMES."""
        return self._y.copy()

    @state.setter
    def state(self, value: Array) -> None:
        self._y = np.array(value, dtype=float).reshape(24)

    @property
    def whole(self) -> Array:
        """A copy of all that the motion goes on from, shape (54,): in the order of WHOLE_NAMES.

        Set it on a march of the same train and steps to go on bit for bit. Raises ValueError for another shape.
        """
        return np.concatenate([self._y, self._z, self._clock, self._place, self._growth])

    @whole.setter
    def whole(self, value: Array) -> None:
        given = np.asarray(value, dtype=float)
        if given.shape != (len(WHOLE_NAMES),):
            raise ValueError(f"The motion's whole state has shape {given.shape}, expected ({len(WHOLE_NAMES)},).")
        self._y, self._z, self._clock, place, self._growth = (
            part.copy() for part in np.split(given, np.cumsum([24, 24, 2, 2]))
        )
        self._place = place.astype(np.int64)

    def advance(
        self,
        start: tuple[float, Inputs],
        end: tuple[float, Inputs],
        collect: Callable[[Array], None] | None = None,
        *,
        room: int = _SECTION_ROOM,
    ) -> tuple[Window, Window]:
        """Advance through inputs linear from `start` to `end`, each (τ, Inputs); return both meshes' windows.

        `collect` gets the section points met, shape (n, 5) in the order of `kernel.SECTION_COLUMNS`, in pieces of up to
        `room`, which changes no number. Raises DivergedError where the solution leaves every bound.
        """
        (tau0, first), (tau1, last) = start, end
        span = tau1 - tau0
        slopes = (
            ((last.frequency - first.frequency) / span, (last.load - first.load) / span) if span > 0 else (0.0, 0.0)
        )
        segment = kernel.Segment(tau0, tau1, first.frequency, slopes[0], first.load, slopes[1])
        window = np.zeros((2, 6))
        window[:, 3], window[:, 4] = inf, -inf
        sections = np.empty((room, 5))
        code = kernel.SECTIONS_FULL
        while code == kernel.SECTIONS_FULL:
            recorded = np.zeros(1, dtype=np.int64)
            code = steps.march(
                self._y,
                self._z,
                self._clock,
                self._place,
                self._growth,
                window,
                sections,
                recorded,
                self._equations,
                self._grid,
                segment,
            )
            if collect is not None and recorded[0]:
                collect(sections[: recorded[0]].copy())
        if code == kernel.DIVERGED:
            raise DivergedError(
                f"The motion diverged at tau {self.tau:.6g} with frequency {last.frequency:.6g} "
                f"and load {last.load:.6g} N·m: "
                f"the parameters are unstable there (parametric resonance) or damping is too low; "
                f"restart, or change them."
            )
        return Window(*map(float, window[0])), Window(*map(float, window[1]))

    def meshes(self, frequency: float) -> Array:
        """Return (δ/b_c, its rate, dimensionless force, in contact) of P12 and P34 now, shape (2, 4)."""
        return np.asarray(kernel.mesh_values(self._y, self._place, frequency, self._equations, self._grid))
