"""Reading a system description: YAML text in, a checked GearTrain out, every refusal one sentence."""

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import hypot, isfinite
from pathlib import Path
from sys import float_info
from typing import Any

import yaml

from seat_gear_dynamics.gears.errors import DescriptionError
from seat_gear_dynamics.gears.excitation import TransmissionErrorHarmonic
from seat_gear_dynamics.gears.schema import (
    BAND_KEYS,
    GEAR_KEYS,
    GEAR_NAMES,
    MESH_KEYS,
    MESHES,
    MODEL_KEYS,
    PROVENANCES,
    SECTIONS,
    SHAFT_KEYS,
    VARIANT_KEYS,
    Key,
)
from seat_gear_dynamics.gears.tooth import contact_ratio, path_of_contact
from seat_gear_dynamics.gears.train import (
    ForbiddenBand,
    Gear,
    GearTrain,
    Mesh,
    Model,
    Provenance,
    Shaft,
    Variant,
    derived_time_scale,
    published_time_scale,
)
from seat_gear_dynamics.gears.units import si_unit, to_si

Values = dict[str, Any]


def packaged_description() -> Path:
    """Return the path of the packaged height adjuster's description."""
    package = Path(__file__).resolve().parents[1]
    # Installed, config/ lies inside the package; in a checkout it stands beside it.
    places = (package / "config", package.parent / "config")
    for place in places:
        if (place / "height_adjuster.yaml").is_file():
            return place / "height_adjuster.yaml"
    raise DescriptionError(
        f"The packaged description height_adjuster.yaml is in neither {places[0]} nor {places[1]}: "
        "reinstall the package."
    )


def load_train(path: str | Path | None = None) -> GearTrain:
    """Read a system description (default: the packaged height adjuster) and return the gear train.

    Raises DescriptionError, one sentence with key, value and expectation, for whatever is not a possible machine.
    """
    source = packaged_description() if path is None else Path(path)
    try:
        text = source.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DescriptionError(
            f"The system description {source} cannot be read ({error}): give a readable YAML file."
        ) from error
    try:
        return parse_train(text)
    except DescriptionError as error:
        raise DescriptionError(f"{source}: {error}") from error


def parse_train(text: str) -> GearTrain:
    """Return the gear train that YAML `text` describes; raises DescriptionError as `load_train` does."""
    try:
        document = yaml.load(text, Loader=_NoDuplicates)
    except DescriptionError:
        raise
    except (yaml.YAMLError, ValueError, TypeError, RecursionError) as error:  # PyYAML lets its constructors' errors out
        raise DescriptionError(f"not valid YAML ({' '.join(str(error).split())}); correct the syntax.") from error
    top = _mapping("the document", document)
    _exact_keys("the document", top, SECTIONS)
    if not isinstance(top["name"], str) or not top["name"]:
        raise DescriptionError(f"name: found {top['name']!r}, expected a text; give the machine a name.")
    reader = _Reader()
    gears_section = _mapping("gears", top["gears"])
    _exact_keys("gears", gears_section, GEAR_NAMES)
    gears = {name: _gear(reader, name, gears_section[name]) for name in GEAR_NAMES}
    meshes_section = _mapping("meshes", top["meshes"])
    _exact_keys("meshes", meshes_section, MESHES)
    meshes = [_mesh(reader, name, meshes_section[name], gears) for name in MESHES]
    shaft = Shaft(**reader.section("shaft", top["shaft"], SHAFT_KEYS))
    variant = Variant(**reader.section("variant", top["variant"], VARIANT_KEYS))
    values = reader.section("model", top["model"], MODEL_KEYS)
    if values["time_scale"] == "published":
        values["time_scale"] = published_time_scale(gears["s1"].teeth)
    elif values["time_scale"] == "derived":
        values["time_scale"] = derived_time_scale(meshes[0])
    bands = _bands(reader, top["bands"])
    return GearTrain(
        top["name"], (meshes[0], meshes[1]), shaft, variant, Model(**values), bands, reader.provenance, text
    )


class _NoDuplicates(yaml.SafeLoader):
    """Refuses a key that stands twice: YAML would silently keep the last."""


def _construct_mapping(loader: yaml.SafeLoader, node: yaml.MappingNode) -> dict[Any, Any]:
    pairs = [(loader.construct_object(k, deep=True), loader.construct_object(v, deep=True)) for k, v in node.value]
    keys = [k for k, _ in pairs]
    for key in keys:
        if keys.count(key) > 1:
            raise DescriptionError(
                f"{key}: the key stands twice in one section (line {node.start_mark.line + 1}); keep one."
            )
    return dict(pairs)


# YAML 1.1 reads 2.05e11 as a text (it wants e+11); people mean the number, as YAML 1.2 has it.
_NoDuplicates.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)
_NoDuplicates.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _construct_mapping)


class _Reader:
    """Converts sections to SI values and keeps where each came from."""

    def __init__(self) -> None:
        self.provenance: dict[str, Provenance] = {}

    def section(self, where: str, raw: object, keys: Mapping[str, Key]) -> Values:
        section = _mapping(where, raw)
        _exact_keys(where, section, keys)
        return {name: self._parameter(f"{where}.{name}", section[name], key) for name, key in keys.items()}

    def _parameter(self, where: str, raw: object, key: Key) -> Any:
        entry = _mapping(where, raw)
        _exact_keys(where, entry, ("value", "unit", "provenance", "source"))
        if entry["provenance"] not in PROVENANCES:
            raise DescriptionError(
                f"{where}.provenance: found {entry['provenance']!r}, "
                f"expected one of {', '.join(PROVENANCES)}; say where the value is from."
            )
        self.provenance[where] = Provenance(entry["provenance"], str(entry["source"]))
        value, unit = entry["value"], entry["unit"]
        to_si(where, 0.0, unit, key.dimension)  # flags and empty lists have a unit too
        if key.kind == "flag":
            if not isinstance(value, bool):
                raise DescriptionError(f"{where}: found {value!r}, expected true or false; correct the value.")
            return value
        if isinstance(value, str) and value in key.words:
            return value
        if key.kind == "list":
            if not isinstance(value, list):
                raise DescriptionError(
                    f"{where}: found {value!r}, expected {key.expectation(si_unit(key.dimension))}; correct the value."
                )
            return tuple(_number(where, item, unit, key) for item in value)
        number = _number(where, value, unit, key)
        return int(number) if key.kind == "integer" else number


def _number(where: str, value: object, unit: object, key: Key) -> float:
    expected = key.expectation(si_unit(key.dimension))
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not abs(value) <= float_info.max:  # type: ignore[arg-type]
        raise DescriptionError(f"{where}: found {value!r}, expected {expected}; correct the value.")
    number = to_si(where, float(value), unit, key.dimension)  # type: ignore[arg-type]
    whole = key.kind != "integer" or number == int(number)
    above = number >= key.low if key.includes_low else number > key.low
    if not (isfinite(number) and whole and above and number <= key.high):
        raise DescriptionError(f"{where}: found {value!r} {unit}, expected {expected}; correct the value.")
    return number


def _gear(reader: _Reader, name: str, raw: object) -> Gear:
    gear = Gear(name=name, **reader.section(f"gears.{name}", raw, GEAR_KEYS))
    expected = gear.tooth.base_radius
    if abs(gear.base_radius / expected - 1) > 0.01:
        raise DescriptionError(
            f"gears.{name}.base_radius: found {gear.base_radius:.6g} m, expected {expected:.6g} m within 1 % "
            f"(module·teeth/2·cos of the pressure angle); correct one of the four."
        )
    if gear.bore_radius >= gear.tooth.root_radius:
        raise DescriptionError(
            f"gears.{name}.bore_radius: found {gear.bore_radius:.6g} m, expected less than the root radius "
            f"{gear.tooth.root_radius:.6g} m; correct the bore."
        )
    return gear


def _mesh(reader: _Reader, name: str, raw: object, gears: Mapping[str, Gear]) -> Mesh:
    values = reader.section(f"meshes.{name}", raw, MESH_KEYS)
    amplitudes, phases = values.pop("error_amplitude"), values.pop("error_phase")
    if len(amplitudes) != len(phases):
        raise DescriptionError(
            f"meshes.{name}.error_phase: found {len(phases)} phases for {len(amplitudes)} amplitudes, "
            f"expected as many; give one phase for each harmonic."
        )
    driver, driven = (gears[gear] for gear in MESHES[name])
    if driver.module != driven.module or driver.pressure_angle != driven.pressure_angle:
        raise DescriptionError(
            f"meshes.{name}: {driver.name} has module {driver.module:g} m and {driven.name} {driven.module:g} m "
            f"(pressure angles {driver.pressure_angle:g} and {driven.pressure_angle:g} rad); "
            f"expected the same, or they do not mesh."
        )
    _check_contact(name, driver, driven)
    harmonics = tuple(
        TransmissionErrorHarmonic(order, amplitude, phase)
        for order, (amplitude, phase) in enumerate(zip(amplitudes, phases, strict=True), start=1)
    )
    return Mesh(name=name, driver=driver, driven=driven, error_harmonics=harmonics, **values)


def _check_contact(name: str, driver: Gear, driven: Gear) -> None:
    """Refuse a pair that involutes cannot drive: contact off the flanks, or fewer than one or more than two pairs."""
    first, second = driver.tooth, driven.tooth
    for gear, own, other in ((driver, first, second), (driven, second, first)):
        start, _ = path_of_contact(own, other)  # the same from either side, seen from `own`
        if start < 0 or hypot(own.base_radius, start) < own.root_radius:
            lowest = own.base_radius if start < 0 else own.root_radius
            raise DescriptionError(
                f"gears.{gear.name}.tooth_height: found {gear.tooth_height:.6g} m on {gear.teeth} teeth, "
                f"but contact in {name} reaches below the involute, which starts at radius {lowest:.6g} m; "
                f"expected a flank as deep as the contact, with enough teeth not to interfere."
            )
    ratio = contact_ratio(first, second)
    if not 1 <= ratio < 2:
        raise DescriptionError(
            f"meshes.{name}: the contact ratio of {driver.name} and {driven.name} is {ratio:.3f}, "
            f"expected 1 to 2, which the stiffness model covers; change teeth or pressure angle."
        )


def _bands(reader: _Reader, raw: object) -> tuple[ForbiddenBand, ...]:
    if not isinstance(raw, list):
        raise DescriptionError(
            f"bands: found {raw!r}, expected a list of bands (it may be empty); correct the section."
        )
    bands = [ForbiddenBand(**reader.section(f"bands[{i}]", entry, BAND_KEYS)) for i, entry in enumerate(raw)]
    for i, band in enumerate(bands):
        if band.low >= band.high:
            raise DescriptionError(
                f"bands[{i}]: low is {band.low:.6g} rad/s and high {band.high:.6g} rad/s, "
                f"expected low below high; swap them."
            )
    ordered = sorted(bands, key=lambda band: band.low)
    for first, second in pairwise(ordered):
        if second.low <= first.high:
            raise DescriptionError(
                f"bands: one ends at {first.high:.6g} rad/s and the next starts at {second.low:.6g} rad/s, "
                f"expected bands apart from each other; merge them."
            )
    return tuple(ordered)


def _mapping(where: str, raw: object) -> dict[str, Any]:
    if not isinstance(raw, dict):
        raise DescriptionError(f"{where}: found {raw!r}, expected a section with keys; correct the section.")
    return raw


def _exact_keys(where: str, section: Mapping[str, Any], keys: Sequence[str] | Mapping[str, Any]) -> None:
    for key in section:
        if key not in keys:
            raise DescriptionError(
                f"{where}.{key}: unknown key with value {section[key]!r}, "
                f"expected one of {', '.join(keys)}; remove it or correct its name."
            )
    for key in keys:
        if key not in section:
            raise DescriptionError(
                f"{where}.{key}: missing key, expected it beside {', '.join(section) or 'nothing'}; add it."
            )
