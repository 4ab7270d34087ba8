"""What a measured bench may change of the model, and how far steel and a seat allow."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from seat_gear_dynamics.gears import GearTrain


@dataclass(frozen=True)
class Parameter:
    """One positive parameter of the fit, searched by its natural logarithm between bounds."""

    name: str
    path: str
    """Where it stands in a system description; empty where it is the sensor's and not the machine's."""
    unit: str
    low: float
    high: float
    reach: float
    """Factor up and down from the start within which other starts are drawn."""
    reason: str
    """Why the bounds stand where they stand."""


PARAMETERS = {
    p.name: p
    for p in (
        Parameter(
            "time_scale", "model.time_scale", "rad/s", 200.0, 4e5, 1.15, "from a tenth of the published to 4 of (15)'s"
        ),
        Parameter(
            "damping",
            "meshes.s1_s2.damping_ratio",
            "1",
            0.003,
            0.5,
            1.6,
            "from bare dry steel to a mesh full of grease",
        ),
        Parameter("stiffness", "meshes.s1_s2.mean_stiffness", "N/m", 1e7, 1e9, 1.3, "section 2.5 puts it there"),
        Parameter("backlash", "meshes.s1_s2.backlash", "m", 1e-6, 2e-4, 1.8, "from ground gears to worn plastic ones"),
        Parameter("load_scale", "model.load_scale", "1", 0.0025, 1.5, 1.4, "the whole static force and friction on it"),
        Parameter("noise", "", "sensor's", 1e-9, 1e9, 3.0, "any: standard deviation of the sensor's white noise"),
    )
}
"""All that may be free; those of P12, which alone is measured: P34 keeps its own."""
DEFAULT = ("time_scale", "damping", "stiffness", "backlash")


@dataclass(frozen=True)
class Candidate:
    """A train and the noise of the sensor beside it."""

    train: GearTrain
    noise: float = 0.0
    """Standard deviation of white noise, in the sensor's unit."""

    def value(self, name: str) -> float:
        """Return a parameter by its name, SI units."""
        mesh, model = self.train.meshes[0], self.train.model
        return {
            "time_scale": model.time_scale,
            "damping": mesh.damping_ratio,
            "stiffness": mesh.mean_model_stiffness,
            "backlash": mesh.backlash,
            "load_scale": model.load_scale,
            "noise": self.noise,
        }[name]

    def with_values(self, names: Sequence[str], values: Sequence[float]) -> "Candidate":
        """Return the candidate with the named parameters (keys of PARAMETERS) at `values`, SI units.

        A mean stiffness scales the computed shape, whether or not the description did.
        """
        given = dict(zip(names, values, strict=True))
        first, second = self.train.meshes
        mesh = replace(
            first,
            damping_ratio=given.get("damping", first.damping_ratio),
            backlash=given.get("backlash", first.backlash),
            mean_stiffness=given.get("stiffness", first.mean_stiffness),
            scale_to_mean=first.scale_to_mean or "stiffness" in given,
        )
        mesh.__dict__["computed_stiffness"] = first.computed_stiffness  # teeth are the same: once is enough
        model = replace(
            self.train.model,
            time_scale=given.get("time_scale", self.train.model.time_scale),
            load_scale=given.get("load_scale", self.train.model.load_scale),
        )
        train = replace(self.train, meshes=(mesh, second), model=model)
        return Candidate(train, given.get("noise", self.noise))


def chosen(names: Sequence[str]) -> tuple[Parameter, ...]:
    """Return the parameters of these names; raises ValueError for none, an unknown one and one named twice."""
    for name in names:
        if name not in PARAMETERS:
            raise ValueError(f"The parameter {name!r} is unknown, expected some of {', '.join(PARAMETERS)}.")
    if not names or len(set(names)) < len(names):
        raise ValueError(f"The free parameters are {', '.join(names) or 'none'}; name at least one, each once.")
    return tuple(PARAMETERS[name] for name in names)
