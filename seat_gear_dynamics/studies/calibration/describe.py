"""A candidate written into the text of a system description, everything else left as it stands."""

import re
from collections.abc import Mapping

from seat_gear_dynamics.gears import GearTrain

_DIGITS = 6
_SOURCE = "search against C1-C10, docs/calibration.md"


def described(text: str, train: GearTrain) -> str:
    """Return the description `text` with the calibrated parameters of `train`, marked as calibrated.

    Values are rounded to six digits. Raises ValueError where `text` has no line for one of them, as a description in
    another layout than the packaged one (one parameter a line) has not.
    """
    lines, section = text.split("\n"), ["", ""]
    wanted = _values(train)
    missing = set(wanted)
    for number, line in enumerate(lines):
        if match := re.match(r"^( *)([\w]+):", line):
            depth, key = len(match[1]) // 2, match[2]
            path = ".".join([*section[:depth], key])
            if depth < 2:
                section[depth] = key
            if path in wanted:
                lines[number] = _replaced(line, wanted[path])
                missing.discard(path)
    if missing:
        raise ValueError(f"The description has no line for {sorted(missing)[0]}; give it one parameter a line.")
    return "\n".join(lines)


def _values(train: GearTrain) -> Mapping[str, str]:
    """Return path -> value as YAML text in the unit of the packaged description."""
    values: dict[str, str] = {"model.load_scale": _number(train.model.load_scale)}
    for gear in train.gears:
        where = f"gears.{gear.name}"
        if gear.name in ("s1", "s2"):
            values[f"{where}.mass"] = _number(gear.mass)
        values[f"{where}.support_stiffness"] = _number(gear.support_stiffness)
        values[f"{where}.support_damping_ratio"] = _number(gear.support_damping_ratio)
        values[f"{where}.torsional_stiffness"] = _number(gear.torsional_stiffness)
        values[f"{where}.torsional_damping_ratio"] = _number(gear.torsional_damping_ratio)
    for mesh in train.meshes:
        where = f"meshes.{mesh.name}"
        values[f"{where}.stiffness_harmonics"] = str(mesh.stiffness_harmonics)
        values[f"{where}.error_amplitude"] = _list([h.amplitude * 1e6 for h in mesh.error_harmonics])
        values[f"{where}.error_phase"] = _list([h.phase for h in mesh.error_harmonics])
    return values


def _number(value: float) -> str:
    return f"{value:.{_DIGITS}g}"


def _list(values: list[float]) -> str:
    return "[" + ", ".join(map(_number, values)) + "]"


def _replaced(line: str, value: str) -> str:
    """Return the parameter's line with another value; what was chosen by analogy keeps its provenance."""
    changed = re.sub(r"(\{value: )(\[[^\]]*\]|[^,]*)", lambda m: m[1] + value, line, count=1)
    changed = changed.replace("provenance: derived", "provenance: calibrated")
    if "provenance: calibrated" in changed:
        changed = re.sub(r'source: (".*"|[^}]*)\}', lambda _: f'source: "{_SOURCE}"}}', changed, count=1)
    return changed
