"""One operating point from drive to regime: the convenience call behind `seat-gear simulate`."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from math import pi
from typing import Any

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import History, Response, System, Window, integrate
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.regimes.classification import Regime, classify


@dataclass(frozen=True)
class MeshForce:
    """Statistics of one mesh force over the sampled periods, N."""

    mean: float
    min: float
    max: float
    rms: float
    contact_loss: float
    """Share of the time out of contact, 0 to 1."""
    static: float
    """What the static chain gives for the torque as stated, N; the model's mean is near `load_scale` times this."""

    @classmethod
    def from_window(cls, window: Window, force_unit: float, static: float) -> "MeshForce":
        """Return the statistics of a dimensionless window in newtons."""
        return cls(
            window.mean * force_unit,
            window.minimum * force_unit,
            window.maximum * force_unit,
            window.rms * force_unit,
            window.contact_loss,
            static,
        )


@dataclass(frozen=True)
class Simulation(Plottable, figure="motion:plot_simulation", table="motions:simulation_table"):
    """What one operating point does."""

    frequency: float
    speed_rpm: float
    load: float
    load_scale: float
    meshes: dict[str, MeshForce]
    regime: Regime
    response: Response

    def history(self, *, periods: int = 12) -> History:
        """Return the motion step by step over `periods` mesh periods more; see `Response.history`."""
        return self.response.history(periods=periods)

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON, forces in N."""
        return {
            "frequency": self.frequency,
            "speed_rpm": self.speed_rpm,
            "load": self.load,
            "load_scale": self.load_scale,
            "meshes": {name: asdict(force) for name, force in self.meshes.items()},
            "regime": self.regime.name,
            "period": self.regime.period,
            "lyapunov": self.regime.lyapunov,
            "lyapunov_error": self.regime.lyapunov_error,
            "label": self.regime.label,
            "pieces": self.regime.pieces,
            "winding": self.regime.winding,
            "zero_one": self.regime.zero_one,
            "reason": self.regime.reason,
        }


def simulate(
    system: System,
    *,
    frequency: float | None = None,
    speed: float | None = None,
    load: float | None = None,
    damping: float | None = None,
    backlash: float | None = None,
    transient: int = 600,
    periods: int = 400,
    progress: Callable[[int, int], None] | None = None,
) -> Simulation:
    """Integrate one operating point and say what kind of motion it is.

    `frequency` is Ω, or `speed` that of s1 in rad/s; `load` is T4, N·m; `damping` (ξ) and `backlash` (m) replace those
    of both meshes. Defaults are the system's own. The regime is P12's. `progress` is told (mesh periods done, in all).
    Raises ValueError for impossible values and
    DivergedError where the solution blows up.
    """
    for name, value in (("damping", damping), ("backlash", backlash)):
        if value is not None and not 0 <= value < float("inf"):
            raise ValueError(f"The {name} is {value!r}, expected a finite number of at least 0.")
    train = system.train
    for index in (0, 1):
        train = train.with_mesh(index, damping_ratio=damping, backlash=backlash)
    at = replace(system, train=train).at(frequency=frequency, speed=speed, load=load)
    response = integrate(at, transient=transient, periods=periods, progress=progress)
    point = at.operating_point
    static = train.static_forces(point.load)
    forces = {
        mesh.name: MeshForce.from_window(window, response.force_unit, force)
        for mesh, window, force in zip(train.meshes, response.windows, static, strict=True)
    }
    regime = classify(response.section, response.growth[:, 0], 2 * pi / abs(point.frequency))
    return Simulation(
        point.frequency,
        train.speed(point.frequency) / RPM,
        point.load,
        train.model.load_scale,
        forces,
        regime,
        response,
    )
