"""Logs of the monitor's outputs, made without a bench by the generator of benchmarks/analysis.py."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.regime_map import RegimeMap, fingerprint

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def generator() -> ModuleType:
    """The module benchmarks/analysis.py, which is no part of the package."""
    spec = importlib.util.spec_from_file_location("benchmark_analysis", ROOT / "benchmarks" / "analysis.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def log(generator: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twelve seconds of up-down: run-up with dwells at 600 and 1300 r/min, then into the band from 1589 r/min."""
    path = tmp_path_factory.mktemp("made") / "log"
    generator.write_log(path, 12.0)
    return path


@pytest.fixture(scope="session")
def bench_dwell() -> Path:
    """A log recorded by a bench, see bags/README.md."""
    return ROOT / "bags" / "bench_dwell"


@pytest.fixture(scope="session")
def made_map() -> Callable[..., RegimeMap]:
    """A function that makes a map of a train: loads in N·m, and for each the spans of r/min that are chaotic.

    Nodes are 50 r/min apart, from 50 to 2100.
    """

    def make(train: GearTrain, loads: list[float], chaotic: list[list[tuple[float, float]]]) -> RegimeMap:
        speeds = np.arange(50.0, 2101.0, 50.0)
        rows = [np.any([(speeds >= low) & (speeds <= high) for low, high in spans], axis=0) for spans in chaotic]
        chaos = np.array(rows).astype(float)
        none = np.zeros(chaos.shape, dtype=np.int64)
        return RegimeMap(
            speeds * RPM, np.array(loads), none, none, chaos, chaos, chaos, chaos, 0, fingerprint(train), 1, 48
        )

    return make
