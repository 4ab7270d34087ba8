"""Logs to write to, and the messages to write."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from seat_gear_dynamics.logs.writer import BagWriter

THIRD_PARTY = Path(__file__).resolve().parents[2] / "bags" / "third_party_bench"


@pytest.fixture
def third_party() -> Path:
    """The recorded bag of another program: 63 s, three topics with 12619 messages each."""
    return THIRD_PARTY


@pytest.fixture
def new_log(tmp_path: Path) -> Callable[..., BagWriter]:
    """Make writers of a log `tmp_path/log` with defaults for what a test does not care about."""

    def make(directory: Path = tmp_path / "log", **arguments: Any) -> BagWriter:
        provenance = {"system_text": "name: test\n", "system_hash": "ab" * 32, "software_version": "0.1.0"}
        return BagWriter(directory, **(provenance | arguments))

    return make
