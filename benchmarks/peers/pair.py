"""P12's equations of motion as plain numbers, for integrators from outside.

    q″ = drive − stiffness·q − damping·q′ − gain·F,  F = κ(Ωτ)·f(δ) + c·δ′,  δ = closing·q − e(Ωτ)

in two exact forms: as (10)-(11) print them, x, y and u of both gears, and with x and y of a gear taken together into
its motion along the line of action, as the lane kernel takes them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain, PeriodicSeries
from seat_gear_dynamics.motion import OperatingPoint, System, coefficients
from seat_gear_dynamics.motion.lanes.reduction import reduce_state, reduced

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pair:
    """P12 under one load; arrays over its n coordinates, n = 6 as printed, 4 reduced."""

    form: str
    closing: Array
    stiffness: Array
    damping: Array
    gain: Array
    drive: Array
    mesh_damping: float
    half_backlash: float
    kappa: PeriodicSeries
    """κ over the mesh phase."""
    error: PeriodicSeries
    """e/b_c over the mesh phase."""
    rest: Array
    """Static deflection with its rates, (2n,)."""
    train: GearTrain
    load: float

    @property
    def coordinates(self) -> int:
        """n."""
        return len(self.closing)

    def of_whole(self, state: Array) -> Array:
        """Return states of the train, (points, 24), as states of this form, (points, 2n)."""
        if self.form == "printed":
            return np.hstack([state[:, :6], state[:, 12:18]])
        along = reduce_state(state, reduced(self.train).line)
        return np.hstack([along[:, :4], along[:, 8:12]])


def pair_of(train: GearTrain, load: float, *, form: str = "printed") -> Pair:
    """Return P12 of `train`, pairs apart and damping always, under `load` (N·m) in one of both forms."""
    c, r, mesh = coefficients(train), reduced(train), train.meshes[0]
    rows = {
        "printed": (c.direction[:6], c.stiffness[:6], c.damping[:6], c.reaction[:6], c.drive[:6]),
        "reduced": (np.ones(4), r.stiffness[:4], r.damping[:4], r.gain[:4], r.drive[:4]),
    }
    closing, stiffness, damping, gain, drive = rows[form]
    made = Pair(
        form,
        closing,
        stiffness,
        damping,
        gain,
        load * drive,
        float(c.mesh_damping[0]),
        float(c.half_backlash[0]),
        mesh.stiffness.scaled(1 / mesh.mean_model_stiffness),
        mesh.transmission_error.scaled(1 / c.length_unit),
        np.empty(0),
        train,
        load,
    )
    rest = made.of_whole(System(train, OperatingPoint(1.0, load)).static_state()[None])[0]
    return Pair(**{**made.__dict__, "rest": rest})


def harmonics(series: Sequence[PeriodicSeries]) -> int:
    """Return how many harmonics the longest of `series` has."""
    return max(len(one.cosine) for one in series)


def value(series: PeriodicSeries, turning: Sequence[tuple[Any, Any]]) -> Any:
    """Return a series of (cos nφ, sin nφ), n = 1 …, numbers or symbols alike."""
    terms = zip(series.cosine, series.sine, turning, strict=False)
    return sum((a * c + b * s for a, b, (c, s) in terms), start=series.mean)


def slope(series: PeriodicSeries, turning: Sequence[tuple[Any, Any]]) -> Any:
    """Return the derivative of a series by φ, likewise."""
    terms = enumerate(zip(series.cosine, series.sine, turning, strict=False), start=1)
    return sum(n * (b * c - a * s) for n, (a, b, (c, s)) in terms)
