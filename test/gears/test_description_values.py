"""What a description's values become: every parameter checked, converted to SI and kept with its provenance."""

from collections.abc import Callable
from copy import deepcopy
from math import pi
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.gears import DescriptionError, GearTrain, load_train
from seat_gear_dynamics.gears.description import parse_train
from seat_gear_dynamics.gears.schema import (
    BAND_KEYS,
    GEAR_KEYS,
    MESH_KEYS,
    MODEL_KEYS,
    PROVENANCES,
    SHAFT_KEYS,
    VARIANT_KEYS,
)

Document = dict[str, Any]

PATHS = sorted(load_train().provenance)
FLAGS = [p for p in PATHS if p.endswith(".scale_to_mean") or p.startswith("variant.")]
SHARED = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def entry(document: Document, path: str) -> Document:
    node: Any = document
    for key in path.replace("[", ".").replace("]", "").split("."):
        node = node[int(key)] if isinstance(node, list) else node[key]
    found: Document = node
    return found


def changed(packaged: Document, path: str, value: object) -> str:
    document = deepcopy(packaged)
    entry(document, path)["value"] = value
    return yaml.safe_dump(document, allow_unicode=True)


def test_every_parameter_of_the_packaged_description_has_its_provenance(packaged: Document) -> None:
    bands = len(packaged["bands"])
    once = len(SHAFT_KEYS) + len(VARIANT_KEYS) + len(MODEL_KEYS)
    assert len(PATHS) == 4 * len(GEAR_KEYS) + 2 * len(MESH_KEYS) + once + bands * len(BAND_KEYS)
    for path, provenance in load_train().provenance.items():
        assert provenance.kind in PROVENANCES
        assert len(provenance.source) > 3
        assert (provenance.kind, provenance.source) == (
            entry(packaged, path)["provenance"],
            entry(packaged, path)["source"],
        )


@SHARED
@given(st.sampled_from(PATHS), st.sampled_from([float("nan"), float("inf"), float("-inf"), "text", None, {}]))
def test_no_parameter_takes_what_is_not_a_finite_value(packaged: Document, path: str, value: object) -> None:
    with pytest.raises(DescriptionError) as caught:
        parse_train(changed(packaged, path, value))
    assert str(caught.value).startswith(f"{path}: found {value!r}, expected ")


@SHARED
@given(st.sampled_from([p for p in PATHS if p not in FLAGS and not p.endswith("_phase")]))
def test_no_parameter_but_a_phase_may_be_negative(packaged: Document, path: str) -> None:
    listed = isinstance(entry(packaged, path)["value"], list)
    with pytest.raises(DescriptionError) as caught:
        parse_train(changed(packaged, path, [-1] if listed else -1))
    assert str(caught.value).startswith(f"{path}: found -1 ")


@SHARED
@given(st.sampled_from([p for p in PATHS if p not in FLAGS]), st.booleans())
def test_true_and_false_are_no_numbers(packaged: Document, path: str, value: bool) -> None:
    with pytest.raises(DescriptionError) as caught:
        parse_train(changed(packaged, path, value))
    assert str(caught.value).startswith(f"{path}: found {value!r}, expected ")


@SHARED
@given(st.sampled_from(PATHS))
def test_no_parameter_takes_a_unit_that_does_not_exist(packaged: Document, path: str) -> None:
    document = deepcopy(packaged)
    entry(document, path)["unit"] = "furlong"
    with pytest.raises(DescriptionError) as caught:
        parse_train(yaml.safe_dump(document, allow_unicode=True))
    assert str(caught.value).startswith(f"{path}: the unit is 'furlong'")


@SHARED
@given(st.sampled_from([p for p in PATHS if p.startswith("gears")]), st.floats(0.01, 100))
def test_whatever_number_a_gear_is_given_it_is_refused_or_has_a_finite_positive_stiffness(
    packaged: Document, path: str, factor: float
) -> None:
    try:
        train = parse_train(changed(packaged, path, entry(packaged, path)["value"] * factor))
    except DescriptionError:
        return
    for mesh in train.meshes:
        assert np.all(np.isfinite(mesh.computed_stiffness.values))
        assert mesh.computed_stiffness.values.min() > 0


@pytest.mark.parametrize(
    ("path", "text", "expected"),
    [
        ("gears.s1.youngs_modulus", "2.05e11", 2.05e11),
        ("gears.s1.youngs_modulus", "2.05E+11", 2.05e11),
        ("gears.s1.inertia", "3.13e-6", 3.13e-6),
        ("gears.s1.inertia", ".313e-5", 3.13e-6),
        ("gears.s1.support_stiffness", "2e7", 2e7),
    ],
)
def test_exponents_are_numbers_however_they_are_written(
    document: Document, path: str, text: str, expected: float
) -> None:
    entry(document, path)["value"] = "PLACE"
    train = parse_train(yaml.safe_dump(document, allow_unicode=True).replace("PLACE", text))
    assert getattr(train.gears[0], path.rsplit(".", 1)[1]) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("path", "value", "unit", "attribute", "expected"),
    [
        ("gears.s1.module", 0.0015, "m", lambda t: t.gears[0].module, 0.0015),
        ("gears.s1.pressure_angle", pi / 9, "rad", lambda t: t.gears[0].pressure_angle, pi / 9),
        ("gears.s1.mass", 40, "g", lambda t: t.gears[0].mass, 0.04),
        ("gears.s1.youngs_modulus", 205, "GPa", lambda t: t.gears[0].youngs_modulus, 2.05e11),
        ("meshes.s1_s2.backlash", 0.02, "mm", lambda t: t.meshes[0].backlash, 2e-5),
        ("meshes.s1_s2.backlash", 20, "µm", lambda t: t.meshes[0].backlash, 2e-5),
        ("bands[0].low", 1200, "rpm", lambda t: t.bands[0].low, 40 * pi),
        ("model.max_load", 700, "Nm", lambda t: t.model.max_load, 700.0),
    ],
)
def test_units_are_converted_to_si(
    document: Document, path: str, value: float, unit: str, attribute: Callable[[GearTrain], float], expected: float
) -> None:
    entry(document, path).update(value=value, unit=unit)

    if path in ("gears.s1.module", "gears.s1.pressure_angle"):  # the pair must be equal to the last bit
        entry(document, path.replace("s1", "s2")).update(value=value, unit=unit)
    train = parse_train(yaml.safe_dump(document, allow_unicode=True))
    assert attribute(train) == pytest.approx(expected, rel=1e-12)


def test_bands_are_sorted_by_speed(document: Document) -> None:
    document["bands"].reverse()
    train = parse_train(yaml.safe_dump(document, allow_unicode=True))
    assert train.bands == load_train().bands
    assert train.bands[0].low < train.bands[1].low


def test_no_bands_are_allowed(document: Document) -> None:
    document["bands"] = []
    assert parse_train(yaml.safe_dump(document, allow_unicode=True)).bands == ()


def test_error_harmonics_are_numbered_from_one(document: Document) -> None:
    entry(document, "meshes.s1_s2.error_amplitude")["value"] = [1, 0.5, 0.25]
    entry(document, "meshes.s1_s2.error_phase")["value"] = [0.1, 0.2, 0.3]
    harmonics = parse_train(yaml.safe_dump(document, allow_unicode=True)).meshes[0].error_harmonics
    assert [(h.order, h.phase) for h in harmonics] == [(1, 0.1), (2, 0.2), (3, 0.3)]
    assert [h.amplitude for h in harmonics] == pytest.approx([1e-6, 5e-7, 2.5e-7])


@SHARED
@given(st.floats(0.5, 2.0))
def test_base_radius_may_be_rounded_by_one_per_cent_and_no_more(packaged: Document, factor: float) -> None:
    exact = 1.5 * 17 / 2 * np.cos(pi / 9)
    assume(abs(abs(factor - 1) - 0.01) > 1e-9)
    text = changed(packaged, "gears.s1.base_radius", float(exact * factor))
    if abs(factor - 1) < 0.01:
        assert parse_train(text).gears[0].base_radius == pytest.approx(exact * factor * 1e-3)
    else:
        with pytest.raises(DescriptionError, match=r"^gears\.s1\.base_radius"):
            parse_train(text)


@pytest.mark.parametrize(("word", "expected"), [("published", 1861.3), ("derived", 1.1594e5)])
def test_the_time_scale_may_be_named(document: Document, word: str, expected: float) -> None:
    entry(document, "model.time_scale")["value"] = word
    train = parse_train(yaml.safe_dump(document, allow_unicode=True))
    assert train.model.time_scale == pytest.approx(expected, rel=2e-4)  # both are known to four digits
    assert train.with_time_scale("published").with_time_scale(word) == train  # type: ignore[arg-type]
