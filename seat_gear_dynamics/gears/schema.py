"""Which keys a system description has, what each measures, and which values are possible."""

from dataclasses import dataclass
from math import inf


@dataclass(frozen=True)
class Key:
    """One parameter of a description: its dimension and the values it may take, in SI units."""

    dimension: str
    low: float = -inf
    high: float = inf
    includes_low: bool = True
    kind: str = "number"
    """`number`, `integer`, `flag`, or `list` (of numbers)."""
    words: tuple[str, ...] = ()
    """Words that stand for a number which the description itself determines."""

    def expectation(self, unit: str) -> str:
        """Return in words what this key accepts, for an error sentence; `unit` is the SI unit."""
        if self.kind == "flag":
            return "true or false"
        noun = {"integer": "a whole number", "list": "a list of finite numbers"}.get(self.kind, "a finite number")
        words = "".join(f"{word!r}, " for word in self.words)
        suffix = "" if unit == "1" else f" {unit}"
        bounds = []
        if self.low != -inf:
            bounds.append(f"{'at least' if self.includes_low else 'greater than'} {self.low:g}{suffix}")
        if self.high != inf:
            bounds.append(f"at most {self.high:g}{suffix}")
        return f"{words}{'or ' if words else ''}{noun} {' and '.join(bounds)}".strip()


def _positive(dimension: str, high: float = inf) -> Key:
    return Key(dimension, 0.0, high, includes_low=False)


GEAR_KEYS = {
    "teeth": Key("number", 6, 1000, kind="integer"),
    "module": _positive("length"),
    "pressure_angle": Key("angle", 0.1, 0.7),
    "tooth_height": _positive("length"),
    "base_radius": _positive("length"),
    "inertia": _positive("inertia"),
    "mass": _positive("mass"),
    "face_width": _positive("length"),
    "bore_radius": _positive("length"),
    "youngs_modulus": _positive("pressure"),
    "poisson_ratio": Key("number", 0.0, 0.5),
    "support_stiffness": _positive("stiffness"),
    "support_clearance_factor": Key("number", 0.0, 1.0),
    "support_damping_ratio": Key("number", 0.0, 1.0),
    "torsional_stiffness": Key("stiffness", 0.0),
    "torsional_damping_ratio": Key("number", 0.0, 1.0),
    "eccentricity": Key("length", 0.0),
    "eccentricity_phase": Key("angle"),
}

MESH_KEYS = {
    "mean_stiffness": _positive("stiffness"),
    "scale_to_mean": Key("number", kind="flag"),
    "stiffness_harmonics": Key("number", 1, 100, kind="integer"),
    "damping_ratio": Key("number", 0.0, 1.0),
    "backlash": Key("length", 0.0),
    "error_amplitude": Key("length", 0.0, kind="list"),
    "error_phase": Key("angle", kind="list"),
}

SHAFT_KEYS = {
    "stiffness": Key("torsional stiffness", 0.0),
    "damping_ratio": Key("number", 0.0, 1.0),
}

VARIANT_KEYS = {
    "backlash_in_torsion": Key("number", kind="flag"),
    "damping_in_contact_only": Key("number", kind="flag"),
}

MODEL_KEYS = {
    "time_scale": Key("angular velocity", 0.0, includes_low=False, words=("published", "derived")),
    "displacement_scale": _positive("length"),
    "load_scale": _positive("number"),
    "max_speed": _positive("angular velocity"),
    "max_load": _positive("torque"),
    "covered_speed": _positive("angular velocity"),
}

BAND_KEYS = {
    "low": _positive("angular velocity"),
    "high": _positive("angular velocity"),
    "load": Key("torque", 0.0),
}

PROVENANCES = ("given", "derived", "calibrated", "chosen")
GEAR_NAMES = ("s1", "s2", "s3", "s4")
MESHES = {"s1_s2": ("s1", "s2"), "s3_s4": ("s3", "s4")}
SECTIONS = ("name", "gears", "meshes", "shaft", "variant", "model", "bands")
