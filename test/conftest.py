"""Gear trains of known parameters, for tests whose numbers must not move with the packaged calibration."""

import os
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import fields, replace
from fnmatch import fnmatch
from typing import Any

import pytest
import yaml
from hypothesis import settings

from seat_gear_dynamics.gears import GearTrain, Mesh, PeriodicSeries, packaged_description
from seat_gear_dynamics.gears.description import parse_train

# CI repeats the same examples, so that a run says something about the commit; a developer's run explores further ones.
# No deadline: a busy machine is no fault of the code.
settings.register_profile("ci", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "explore")

Document = dict[str, Any]

# Every value of the packaged description that the paper does not give, in the units of that description.
_FIXED: dict[str, object] = {
    "gears.s1.mass": 0.04,
    "gears.s2.mass": 0.18,
    "gears.s3.mass": 0.085,
    "gears.s4.mass": 0.25,
    "gears.s1.bore_radius": 4,
    "gears.s2.bore_radius": 8,
    "gears.s3.bore_radius": 8,
    "gears.s4.bore_radius": 10,
    "gears.*.support_stiffness": 2e7,
    "gears.*.support_clearance_factor": 1,
    "gears.*.support_damping_ratio": 0.05,
    "gears.*.torsional_stiffness": 2000,
    "gears.*.torsional_damping_ratio": 0.1,
    "gears.*.eccentricity": 0,
    "gears.*.eccentricity_phase": 0,
    "meshes.*.scale_to_mean": True,
    "meshes.*.stiffness_harmonics": 8,
    "meshes.*.damping_ratio": 0.07,
    "meshes.*.backlash": 20,
    "meshes.*.error_amplitude": [1.2, 0.5],
    "meshes.*.error_phase": [0.4, 2.0],
    "shaft.stiffness": 0,
    "variant.backlash_in_torsion": True,
    "variant.damping_in_contact_only": False,
    "model.time_scale": 1861.5,
    "model.displacement_scale": 10,
    "model.load_scale": 0.05,
    "model.max_speed": 12000,
    "model.max_load": 5000,
    "model.covered_speed": 2101.6,
}


class SteadyMesh(Mesh):
    """A mesh of constant stiffness: its mean at every phase."""

    @property
    def stiffness(self) -> PeriodicSeries:
        """The mean stiffness, N/m."""
        return PeriodicSeries(self.mean_model_stiffness, (0.0,), (0.0,))


@pytest.fixture(scope="session")
def packaged() -> Document:
    """The packaged description as plain data; not to be changed."""
    # YAML 1.1 takes 2.05e11 for a text, so every value that reads as a number is made one.
    document: Document = yaml.safe_load(packaged_description().read_text(encoding="utf-8"))
    for entry in parameters(document).values():
        if isinstance(entry["value"], str):
            entry["value"] = float(entry["value"])
    return document


@pytest.fixture
def document(packaged: Document) -> Document:
    """The packaged description as plain data of the test's own."""
    return deepcopy(packaged)


@pytest.fixture(scope="session")
def make_train(packaged: Document) -> Callable[..., GearTrain]:
    """Make a train of fixed parameters; edits are {path pattern: value in the description's unit}."""

    def make(edits: Mapping[str, object] | None = None) -> GearTrain:
        described = deepcopy(packaged)
        entries = parameters(described)
        for pattern, value in (_FIXED | dict(edits or {})).items():
            matching = [path for path in entries if fnmatch(path, pattern)]
            assert matching, f"no parameter is named {pattern}"
            for path in matching:
                entries[path]["value"] = value
        return parse_train(yaml.safe_dump(described, allow_unicode=True))

    return make


@pytest.fixture(scope="session")
def train(make_train: Callable[..., GearTrain]) -> GearTrain:
    """The train of fixed parameters, without edits."""
    return make_train()


@pytest.fixture(scope="session")
def steady() -> Callable[[GearTrain], GearTrain]:
    """Take the stiffness variation out of a train, which a description cannot."""

    def without_variation(train: GearTrain) -> GearTrain:
        first, second = (SteadyMesh(**{f.name: getattr(m, f.name) for f in fields(m)}) for m in train.meshes)
        return replace(train, meshes=(first, second))

    return without_variation


@pytest.fixture(scope="session")
def conservative(make_train: Callable[..., GearTrain], steady: Callable[[GearTrain], GearTrain]) -> GearTrain:
    """A train without damping, transmission error and stiffness variation: nothing adds or takes energy."""
    return steady(make_train({"*damping_ratio": 0, "*.error_amplitude": [0], "*.error_phase": [0]}))


def parameters(document: Document) -> dict[str, Document]:
    """Return every parameter entry of a description by its path, as in gears.s1.mass or bands[0].low."""
    found: dict[str, Document] = {}

    def visit(path: str, node: object) -> None:
        if isinstance(node, dict) and "value" in node:
            found[path] = node
        elif isinstance(node, dict):
            for key, child in node.items():
                visit(f"{path}.{key}" if path else key, child)
        elif isinstance(node, list):
            for index, child in enumerate(node):
                visit(f"{path}[{index}]", child)

    visit("", document)
    return found
