"""A gear train at an operating point: the plain right-hand side that any ODE solver can be pointed at."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isfinite, pi
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.gears import GearTrain, load_train
from seat_gear_dynamics.motion.coefficients import (
    COORDINATES,
    PER_MESH,
    Coefficients,
    coefficients,
    mesh_rate,
    static_state,
)

Array = NDArray[np.float64]

STATE_NAMES: tuple[str, ...] = tuple(
    f"{coordinate}{gear}{rate}" for rate in ("", "'") for gear in (1, 2, 3, 4) for coordinate in ("x", "y", "u")
)
"""Order of the state: x1, y1, u1, … x4, y4, u4, then their rates; u = r·θ; all over b_c, rates per unit of τ."""


@dataclass(frozen=True)
class OperatingPoint:
    """A steady drive: dimensionless mesh frequency of P12 (signed) and load torque T4, N·m."""

    frequency: float = 0.5
    load: float = 600.0

    def __post_init__(self) -> None:
        for name, value in (("frequency", self.frequency), ("load", self.load)):
            if not isfinite(value):
                raise ValueError(f"The operating point's {name} is {value!r}, expected a finite number.")


@dataclass(frozen=True)
class System:
    """The equations of motion (14)-(19) of a gear train at an operating point, with f(δ) in every line.

    The train's `variant` and `shaft` say which reading of them: f(δ) or δ in the torsional lines, damping always or in
    contact only, pairs apart as printed or coupled by the shaft of s2 and s3.
    """

    train: GearTrain
    operating_point: OperatingPoint = field(default_factory=OperatingPoint)

    @cached_property
    def coefficients(self) -> Coefficients:
        """The dimensionless coefficients of the train."""
        return coefficients(self.train)

    @cached_property
    def mesh_rates(self) -> tuple[float, float]:
        """Mesh frequencies of P12 and P34 over that of P12: 1 and z3/z2."""
        return mesh_rate(self.train, 0), mesh_rate(self.train, 1)

    def at(self, *, frequency: float | None = None, speed: float | None = None, load: float | None = None) -> "System":
        """Return the system at another operating point.

        `frequency` is Ω; `speed` is the speed of s1, rad/s; give at most one. `load` is T4, N·m.
        """
        if frequency is not None and speed is not None:
            raise ValueError(f"Both frequency {frequency!r} and speed {speed!r} were given; give one of them.")
        point = self.operating_point
        if speed is not None:
            frequency = self.train.frequency(speed)
        return replace(
            self,
            operating_point=OperatingPoint(
                point.frequency if frequency is None else frequency, point.load if load is None else load
            ),
        )

    def static_state(self) -> Array:
        """Return the state at rest under the operating point's load, shape (24,)."""
        return static_state(self.train, self.operating_point.load)

    def derivative(self, t: float, state: ArrayLike) -> Array:
        """Return d(state)/dτ at dimensionless time `t` = τ = ω_d·t, shape (24,) in the order of STATE_NAMES.

        Source: (10)-(19), with δ from the digest. A plain NumPy function without state of its own, as
        `scipy.integrate.solve_ivp` wants it; the compiled march is the fast way.
        """
        y = np.asarray(state, dtype=float)
        if y.shape != (2 * COORDINATES,):
            raise ValueError(f"The state has shape {y.shape}, expected (24,): {', '.join(STATE_NAMES[:3])}, ….")
        c, (q, v) = self.coefficients, (y[:COORDINATES], y[COORDINATES:])
        acceleration = self.operating_point.load * c.drive - c.stiffness * q - c.damping * v
        acceleration -= c.reaction * np.concatenate([np.tile(line, 2) for line in self._line_forces(t, y)])
        twist = c.shaft_stiffness * (c.shaft_direction @ q) + c.shaft_damping * (c.shaft_direction @ v)
        return np.concatenate([v, acceleration - c.shaft_reaction * twist])

    def deflections(self, t: float, state: ArrayLike) -> tuple[Array, Array]:
        """Return (δ_j/b_c, its rate per τ) of both meshes, each of shape (2,)."""
        y, c = np.asarray(state, dtype=float), self.coefficients
        closing = (y.reshape(4, PER_MESH) * np.tile(c.direction, 2).reshape(4, PER_MESH)).sum(axis=1)
        phases = self.mesh_phases(t)
        rates = np.array(self.mesh_rates) * self.operating_point.frequency / (2 * pi)
        errors = [m.transmission_error for m in self.train.meshes]
        e = np.array([float(series.value(p)) for series, p in zip(errors, phases, strict=True)])
        slope = np.array([float(series.derivative(p)) for series, p in zip(errors, phases, strict=True)])
        runout, runout_slope = self._runout(t)
        return (
            closing[:2] - e / c.length_unit - runout,
            closing[2:] - slope * rates / c.length_unit - runout_slope * rates[0],
        )

    def mesh_forces(self, t: float, state: ArrayLike) -> Array:
        """Return the dimensionless mesh forces κ·f(δ) + c·δ′ of P12 and P34, shape (2,); times `force_unit` is N."""
        return np.asarray(self._line_forces(t, np.asarray(state, dtype=float))[:, 0])

    def _line_forces(self, t: float, y: Array) -> Array:
        """Return what each mesh pulls with in the lines of x, y and u, shape (2, 3); they differ only as printed."""
        c = self.coefficients
        delta, rate = self.deflections(t, y)
        beyond = delta - np.clip(delta, -c.half_backlash, c.half_backlash)  # f(δ) of (1)
        mean = self.train.meshes[0].mean_model_stiffness
        phases = self.mesh_phases(t)
        kappa = np.array([float(m.stiffness.value(p)) / mean for m, p in zip(self.train.meshes, phases, strict=True)])
        damper = c.mesh_damping * rate
        if c.damping_in_contact_only:
            damper = np.where(beyond == 0, 0.0, damper)
        torsional = beyond if c.backlash_in_torsion else delta
        return np.column_stack([kappa * beyond + damper, kappa * beyond + damper, kappa * torsional + damper])

    def _runout(self, t: float) -> tuple[Array, Array]:
        """Return each mesh's error by eccentric gears over b_c, and its slope per mesh period of P12, each (2,)."""
        c = self.coefficients
        angle = c.shaft_turns * self.operating_point.frequency * t + c.eccentricity_phase
        value, slope = c.eccentricity * np.sin(angle), 2 * pi * c.shaft_turns * c.eccentricity * np.cos(angle)
        return value.reshape(2, 2).sum(axis=1), slope.reshape(2, 2).sum(axis=1)

    def mesh_phases(self, t: float) -> Array:
        """Return the mesh phases of P12 and P34 in [0, 1) at dimensionless time `t`, shape (2,)."""
        return np.asarray(np.array(self.mesh_rates) * self.operating_point.frequency * t / (2 * pi) % 1.0)


def load_system(path: str | Path | None = None) -> System:
    """Read a system description (default: the packaged height adjuster) and return the system at Ω = 0.5, 600 N·m.

    Raises `seat_gear_dynamics.gears.DescriptionError`, one sentence, where the description is not a possible machine.
    """
    return System(load_train(path))
