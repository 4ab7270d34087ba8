"""Waveforms of the model at steady drives: what a force sensor or an accelerometer would show, sample by sample."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import kernel, stages, steps, vectors
from seat_gear_dynamics.motion.coefficients import Coefficients, coefficients
from seat_gear_dynamics.motion.kernel import Equations, Grid, Segment
from seat_gear_dynamics.motion.march import LONGEST_STEP, March
from seat_gear_dynamics.motion.revision import revision
from seat_gear_dynamics.motion.tables import LEVELS

Array = NDArray[np.float64]

STEPS = 136
"""Steps per mesh period of a run-in: half of the production march's, an error of the state of 1e-5 off impacts."""
FINER = 2
"""Levels by which a waveform is finer than a run-in, 544 samples a period. An impulse lasts a twentieth of a period:
with 68 samples its quantiles err by 1.4 %, now up and now down as a parameter changes, with 544 by 0.07 %."""
_GEARS = {"s1": 0, "s2": 1}


@dataclass(frozen=True)
class Sensor:
    """What is measured of P12: the mesh force in N, or a gear's acceleration along the line of action in m/s²."""

    kind: str = "force"
    """`force` or `acceleration`."""
    gear: str = "s1"
    """The gear whose centre an accelerometer follows, `s1` or `s2`; idle for a force."""

    def __post_init__(self) -> None:
        for what, found, known in (("kind", self.kind, ("force", "acceleration")), ("gear", self.gear, tuple(_GEARS))):
            if found not in known:
                raise ValueError(f"The sensor's {what} is {found!r}, expected one of {', '.join(known)}.")

    @property
    def unit(self) -> str:
        """The SI unit of what is measured."""
        return "N" if self.kind == "force" else "m/s²"


def waveform(
    train: GearTrain, sensor: Sensor, *, frequency: float, load: float, state: Array, periods: int = 1
) -> Array:
    """Return what `sensor` shows of `train` over `periods` mesh periods of P12, shape (n·periods,), SI units.

    Starts at mesh phase 0 in `state` (24,), at the dimensionless signed `frequency` (not 0) and `load` (T4, N·m), and
    samples at equal steps of phase, n of them a period (544 for the paper's teeth). A force is (1), (2) of the paper.
    An acceleration is the centre's, by the lines of x and y of (10), (11), in the bench's own seconds: it carries the
    square of the train's time scale. NaN from where the motion diverges. Raises ValueError at a frequency below the
    slowest grid. Limit: a sensor on a housing also shows the housing; here it sits on the gear's support.
    """
    march = March(train, load=load, target_steps=STEPS)
    equations, grid = march.compiled
    samples, level = grid.base << FINER, max(_level(frequency, grid.base), FINER)
    # The coarsest level whose step is short enough is taken; its own step, but for rounding, makes that `level`.
    grid = grid._replace(longest_step=2 * np.pi / (abs(frequency) * (grid.base << level)) * (1 + 1e-9))
    stride, rows = 1 << (level - FINER), samples * periods
    states, forces = np.full((rows, 24), np.nan), np.full((rows, 2), np.nan)
    _record(np.array(state, dtype=float), equations, grid, frequency, load, stride, states, forces)
    if sensor.kind == "force":
        return forces[:, 0] * march.force_unit
    return _acceleration(coefficients(train), train, _GEARS[sensor.gear], states, forces[:, 0], load)


def _level(frequency: float, base: int) -> int:
    for level in range(LEVELS):
        if 2 * np.pi <= LONGEST_STEP * abs(frequency) * base * (1 << level):
            return level
    raise ValueError(f"The frequency is {frequency!r}, too slow for a step locked to the mesh; give a faster dwell.")


def _acceleration(c: Coefficients, train: GearTrain, gear: int, states: Array, force: Array, load: float) -> Array:
    """Return the acceleration of a gear's centre along the line of action, towards closing the mesh, m/s²."""
    own = slice(3 * gear, 3 * gear + 2)
    q, v = states[:, own], states[:, 12 + 3 * gear : 14 + 3 * gear]
    per_tau = load * c.drive[own] - c.stiffness[own] * q - c.damping[own] * v - np.outer(force, c.reaction[own])
    return np.asarray(per_tau @ c.direction[own]) * c.length_unit * train.model.time_scale**2


def _entry(revision: int) -> Any:
    @njit(cache=True, error_model="numpy", nogil=True)
    def record(
        y: Array,
        equations: Equations,
        grid: Grid,
        frequency: float,
        load: float,
        stride: int,
        states: Array,
        forces: Array,
    ) -> None:
        """Fill states (n, 24) and dimensionless forces (n, 2), one row each `stride` steps from mesh phase 0 on."""
        _ = revision
        z, growth, window = np.zeros(24), np.zeros(2), np.zeros((2, 6))
        clock, place = np.zeros(2), np.zeros(2, dtype=np.int64)
        sections, recorded = np.empty((8, 5)), np.zeros(1, dtype=np.int64)
        z[0] = z[6] = 1.0
        for row in range(len(states)):
            states[row] = y
            mesh = kernel.mesh_values(y, place, frequency, equations, grid)
            forces[row, 0], forces[row, 1] = mesh[0, 2], mesh[1, 2]
            for _step in range(stride):
                recorded[0] = 0
                # Any end that is later than the start makes exactly one step: a step that has begun is made whole.
                segment = Segment(clock[0], clock[0] + 1e-9 * (1.0 + clock[0]), frequency, 0.0, load, 0.0)
                code = steps.march(y, z, clock, place, growth, window, sections, recorded, equations, grid, segment)
                if code != 0:
                    return

    return record


_record = _entry(revision(kernel, stages, vectors, steps))
