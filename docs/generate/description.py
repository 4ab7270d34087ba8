"""Every key of a system description: what it takes, what it means, and its value in the packaged one."""

import ast
import inspect
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import yaml

from docs.generate.markdown import code, plain, table
from seat_gear_dynamics.gears import packaged_description, schema, train
from seat_gear_dynamics.gears.units import _FACTORS, si_unit

# Keys of the YAML that the typed description holds under another name, or not as a field of its own.
_ELSEWHERE = {
    "error_amplitude": "Amplitudes of the transmission error's harmonics of the mesh frequency, first to last.",
    "error_phase": "Their phases, as many.",
    "low": "Lower edge of a published band, speed of s1.",
    "high": "Upper edge of a published band, speed of s1.",
    "teeth": "Number of teeth.",
    "module": "Module.",
    "pressure_angle": "Pressure angle.",
    "base_radius": "Radius of the base circle, on which the line of action acts.",
    "inertia": "Moment of inertia about the axis.",
    "mass": "Mass, for the motion of the axis.",
    "face_width": "Width of the teeth.",
    "bore_radius": "Radius of the bore, for the foundation's compliance.",
    "youngs_modulus": "Young's modulus.",
    "poisson_ratio": "Poisson's ratio.",
    "torsional_damping_ratio": "Of the gear's inertia on its torsional support.",
    "displacement_scale": "b_c, the length that displacements are divided by.",
}
_SECTIONS: Mapping[str, tuple[str, Mapping[str, schema.Key], str, str]] = {
    "gears": ("gears.s1 … gears.s4", schema.GEAR_KEYS, "Gear", "s1"),
    "meshes": ("meshes.s1_s2, meshes.s3_s4", schema.MESH_KEYS, "Mesh", "s1_s2"),
    "shaft": ("shaft", schema.SHAFT_KEYS, "Shaft", ""),
    "variant": ("variant", schema.VARIANT_KEYS, "Variant", ""),
    "model": ("model", schema.MODEL_KEYS, "Model", ""),
    "bands": ("bands (a list)", schema.BAND_KEYS, "ForbiddenBand", "0"),
}


def reference() -> str:
    """Return a section for each part of the file, with one row for each key."""
    packaged = yaml.safe_load(packaged_description().read_text(encoding="utf-8"))
    return "\n\n".join(_section(packaged[name], *part) for name, part in _SECTIONS.items())


def units() -> str:
    """Return the units that a value may be written in, by what they measure."""
    rows = [(dimension, ", ".join(code(unit) for unit in factors)) for dimension, factors in _FACTORS.items()]
    return table(("quantity", "units"), rows)


def _section(packaged: Any, title: str, keys: Mapping[str, schema.Key], kind: str, first: str) -> str:
    values = packaged[int(first) if first.isdigit() else first] if first else packaged
    meanings = field_words(kind)
    rows = [_row(name, key, values[name], meanings.get(name, "")) for name, key in keys.items()]
    of = f" of {first}" if first and not first.isdigit() else ""
    return f"## {title}\n\n" + table(("key", "meaning", "takes, in SI units", f"packaged value{of}"), rows)


def _row(name: str, key: schema.Key, value: Mapping[str, Any], meaning: str) -> tuple[str, str, str, str]:
    said = _ELSEWHERE.get(name) or meaning
    if not said:
        raise ValueError(f"Nothing says what the key {name} means; add a docstring to its field in gears/train.")
    unit = "" if value["unit"] == "1" else f" {value['unit']}"
    found = f"{_shown(value['value'])}{unit}, {value['provenance']}"
    return code(name), plain(said), plain(key.expectation(si_unit(key.dimension))), plain(found)


def _shown(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def field_words(name: str, module: Any = train) -> dict[str, str]:
    """Return field → its docstring, of a class in `module`."""
    tree = ast.parse(inspect.getsource(module))
    body = next(node.body for node in tree.body if isinstance(node, ast.ClassDef) and node.name == name)
    words = {}
    for field, text in pairwise(body):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(text, ast.Expr):
            words[field.target.id] = str(ast.literal_eval(text.value)).strip()
    return words
