"""Logs of the monitor's outputs, made without a bench by the generator of benchmarks/analysis.py."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

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
