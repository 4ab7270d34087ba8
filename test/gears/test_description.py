"""What a description must look like: every refusal is one sentence with key, value and expectation."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from seat_gear_dynamics.gears import DescriptionError, load_train, packaged_description
from seat_gear_dynamics.gears.description import parse_train

Document = dict[str, Any]
Edit = Callable[[Document], object]


def refusal(text: str) -> str:
    """Return the sentence that `text` is refused with."""
    with pytest.raises(DescriptionError) as caught:
        parse_train(text)
    message = str(caught.value)
    assert message.endswith(".")
    assert "\n" not in message
    assert ". " not in message
    return message


def dumped(document: Document) -> str:
    return yaml.safe_dump(document, allow_unicode=True)


def band(low: float, high: float) -> Document:
    stem = {"provenance": "chosen", "source": "a test"}
    speeds = {name: {"value": v, "unit": "r/min"} | stem for name, v in (("low", low), ("high", high))}
    return speeds | {"load": {"value": 600, "unit": "N·m"} | stem}


def s1(document: Document) -> Document:
    gear: Document = document["gears"]["s1"]
    return gear


def mesh(document: Document) -> Document:
    section: Document = document["meshes"]["s1_s2"]
    return section


WRONG: dict[str, tuple[Edit, tuple[str, ...]]] = {
    "unknown section": (
        lambda d: d.update(colour="red"),
        ("the document.colour", "'red'", "expected one of name, gears"),
    ),
    "unknown gear": (lambda d: d["gears"].update(s5={}), ("gears.s5", "unknown", "s1, s2, s3, s4")),
    "unknown gear parameter": (lambda d: s1(d).update(colour=3), ("gears.s1.colour", "3", "expected one of teeth")),
    "unknown entry": (lambda d: s1(d)["mass"].update(note="x"), ("gears.s1.mass.note", "'x'", "expected one of value")),
    "missing section": (lambda d: d.pop("model"), ("the document.model", "missing")),
    "missing gear": (lambda d: d["gears"].pop("s4"), ("gears.s4", "missing", "s1, s2, s3")),
    "missing parameter": (lambda d: s1(d).pop("mass"), ("gears.s1.mass", "missing")),
    "missing mesh": (lambda d: d["meshes"].pop("s3_s4"), ("meshes.s3_s4", "missing", "s1_s2")),
    "missing mesh parameter": (lambda d: mesh(d).pop("backlash"), ("meshes.s1_s2.backlash", "missing")),
    "missing model parameter": (lambda d: d["model"].pop("load_scale"), ("model.load_scale", "missing")),
    "missing band edge": (lambda d: d["bands"][1].pop("high"), ("bands[1].high", "missing")),
    "missing value": (lambda d: s1(d)["mass"].pop("value"), ("gears.s1.mass.value", "missing")),
    "missing unit": (lambda d: s1(d)["mass"].pop("unit"), ("gears.s1.mass.unit", "missing")),
    "missing provenance": (lambda d: s1(d)["mass"].pop("provenance"), ("gears.s1.mass.provenance", "missing")),
    "missing source": (lambda d: s1(d)["mass"].pop("source"), ("gears.s1.mass.source", "missing")),
    "wrong provenance": (
        lambda d: s1(d)["mass"].update(provenance="guessed"),
        ("gears.s1.mass.provenance", "'guessed'", "given, derived, calibrated, chosen"),
    ),
    "wrong unit": (lambda d: s1(d)["mass"].update(unit="mm"), ("gears.s1.mass", "'mm'", "a mass", "'kg', 'g'")),
    "a number for a unit": (lambda d: s1(d)["mass"].update(unit=1), ("gears.s1.mass", "unit is 1", "'kg'")),
    "wrong unit of a flag": (
        lambda d: mesh(d)["scale_to_mean"].update(unit="mm"),
        ("meshes.s1_s2.scale_to_mean", "'mm'", "'1'"),
    ),
    "wrong unit of an empty list": (
        lambda d: mesh(d)["error_amplitude"].update(value=[], unit="kg"),
        ("meshes.s1_s2.error_amplitude", "'kg'", "a length"),
    ),
    "a bare number": (lambda d: s1(d).update(mass=0.04), ("gears.s1.mass", "0.04", "a section with keys")),
    "non-integer teeth": (lambda d: s1(d)["teeth"].update(value=17.5), ("gears.s1.teeth", "17.5", "a whole number")),
    "too few teeth": (lambda d: s1(d)["teeth"].update(value=5), ("gears.s1.teeth", "found 5", "at least 6")),
    "negative inertia": (
        lambda d: s1(d)["inertia"].update(value=-1e-6),
        ("gears.s1.inertia", "-1e-06", "greater than 0 kg·m²"),
    ),
    "zero mass": (lambda d: s1(d)["mass"].update(value=0), ("gears.s1.mass", "found 0 kg", "greater than 0 kg")),
    "half as a Poisson ratio and more": (
        lambda d: s1(d)["poisson_ratio"].update(value=0.51),
        ("gears.s1.poisson_ratio", "0.51", "at least 0 and at most 0.5"),
    ),
    "a number beyond floats": (
        lambda d: s1(d)["mass"].update(value=10**400),
        ("gears.s1.mass", "a finite number greater than 0 kg"),
    ),
    "a number beyond floats in SI": (
        lambda d: s1(d)["youngs_modulus"].update(value=1e300, unit="GPa"),
        ("gears.s1.youngs_modulus", "1e+300 GPa", "a finite number"),
    ),
    "a number for a flag": (
        lambda d: mesh(d)["scale_to_mean"].update(value=1),
        ("meshes.s1_s2.scale_to_mean", "found 1", "true or false"),
    ),
    "a number for a list": (
        lambda d: mesh(d)["error_phase"].update(value=1.0),
        ("meshes.s1_s2.error_phase", "found 1.0", "a list of finite numbers"),
    ),
    "NaN in a list": (
        lambda d: mesh(d)["error_phase"].update(value=[1.0, float("nan")]),
        ("meshes.s1_s2.error_phase", "found nan", "a list of finite numbers"),
    ),
    "unequal error lists": (
        lambda d: mesh(d)["error_phase"].update(value=[1.0] * 7),
        ("meshes.s1_s2.error_phase", "7 phases", "expected as many"),
    ),
    "inconsistent base radius": (
        lambda d: s1(d)["base_radius"].update(value=12.2),
        ("gears.s1.base_radius", "0.0122 m", "0.0119811 m within 1 %"),
    ),
    "bore too large": (
        lambda d: s1(d)["bore_radius"].update(value=11),
        ("gears.s1.bore_radius", "0.011 m", "less than the root radius 0.010875 m"),
    ),
    "modules that do not mesh": (
        lambda d: [d["gears"]["s2"][k].update(value=v) for k, v in (("module", 1.6), ("base_radius", 30.07))],
        ("meshes.s1_s2", "module 0.0015 m", "0.0016 m", "expected the same"),
    ),
    "teeth too short to mesh": (
        lambda d: s1(d)["tooth_height"].update(value=0.5),
        ("gears.s1.tooth_height", "0.0005 m", "expected a flank as deep as the contact"),
    ),
    "so few teeth that they interfere": (
        lambda d: [s1(d)[k].update(value=v) for k, v in (("teeth", 8), ("base_radius", 5.638), ("bore_radius", 2))],
        ("gears.s1.tooth_height", "8 teeth", "enough teeth not to interfere"),
    ),
    "band upside down": (
        lambda d: d.update(bands=[band(200, 100)]),
        ("bands[0]", "20.944", "10.472", "low below high"),
    ),
    "empty band": (lambda d: d.update(bands=[band(100, 100)]), ("bands[0]", "low below high")),
    "overlapping bands": (
        lambda d: d.update(bands=[band(150, 300), band(100, 200)]),
        ("bands", "20.944", "15.708", "apart from each other"),
    ),
    "bands that are no list": (lambda d: d.update(bands="none"), ("bands", "'none'", "a list of bands")),
    "a band that is no section": (lambda d: d.update(bands=[7]), ("bands[0]", "found 7", "a section with keys")),
    "gears that are no section": (lambda d: d.update(gears=[1]), ("gears", "found [1]", "a section with keys")),
    "no name": (lambda d: d.update(name=""), ("name", "found ''", "a text")),
    "a number for a name": (lambda d: d.update(name=5), ("name", "found 5", "a text")),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_description_is_refused_in_one_sentence_with_key_value_and_expectation(
    document: Document, case: str
) -> None:
    edit, expected = WRONG[case]
    edit(document)
    message = refusal(dumped(document))
    for words in expected:
        assert words in message
    assert message.startswith(expected[0])


BAD_TEXT = {
    "empty": ("", "the document: found None, expected a section"),
    "a list": ("- 1", "the document: found [1], expected a section"),
    "unbalanced brackets": ("gears: [1", "not valid YAML"),
    "a tab for indentation": ("gears:\n\t- 1", "not valid YAML"),
    "a character YAML forbids": ("name: a\0b", "not valid YAML"),
    "two documents": ("a: 1\n---\nb: 2", "not valid YAML"),
    "an object of Python's": ("!!python/object/apply:os.getcwd []", "not valid YAML"),
    "a node that holds itself": ("&a {x: *a}", "not valid YAML"),
    "a list for a key": ("? [1, 2]\n: 3", "not valid YAML (unhashable type: 'list')"),
    "a date that does not exist": ("name: 2024-99-01", "not valid YAML (month must be in 1..12)"),
    "brackets without end": ("[" * 5000, "not valid YAML"),
    "a duplicate key": ("name: a\nname: b", "name: the key stands twice in one section (line 1)"),
    "a duplicate key further in": ("gears:\n  s1: {mass: 1, mass: 2}", "mass: the key stands twice"),
}


@pytest.mark.parametrize("case", BAD_TEXT)
def test_text_that_is_no_description_is_refused_in_one_sentence(case: str) -> None:
    text, expected = BAD_TEXT[case]
    assert expected in refusal(text)


def test_missing_file_is_refused_by_its_path(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"nowhere\.yaml cannot be read .*: give a readable YAML file\.$"):
        load_train(tmp_path / "nowhere.yaml")


def test_directory_is_refused_by_its_path(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="cannot be read"):
        load_train(tmp_path)


def test_file_that_is_not_utf_8_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "latin.yaml"
    path.write_bytes("name: Höhe".encode("latin-1"))
    with pytest.raises(DescriptionError, match=r"latin\.yaml cannot be read"):
        load_train(path)


def test_refusal_of_a_file_names_the_file(tmp_path: Path) -> None:
    path = tmp_path / "empty.yaml"
    path.touch()
    with pytest.raises(DescriptionError, match=r"empty\.yaml: the document: found None"):
        load_train(str(path))


def test_file_and_text_give_the_same_train(tmp_path: Path, document: Document) -> None:
    path = tmp_path / "own.yaml"
    path.write_text(dumped(document), encoding="utf-8")
    assert load_train(path) == parse_train(dumped(document))


def test_packaged_description_is_what_is_loaded_by_default() -> None:
    assert load_train() == load_train(packaged_description())
