"""Small logs to damage, and what they hold."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from seat_gear_dynamics.logs.topics import FLOAT64
from seat_gear_dynamics.logs.writer import BagWriter

TEXT = "name: test\n"


def write_small_log(directory: Path, count: int = 60, **arguments: Any) -> Path:
    defaults: dict[str, Any] = {"chunk_size": 400, "compression": "none", "software_version": "0.1.0"}
    identity = {"system_text": TEXT, "system_hash": hashlib.sha256(TEXT.encode()).hexdigest()}
    with BagWriter(directory, **(identity | defaults | arguments)) as log:
        log.add_topic("/a", FLOAT64)
        log.add_topic("/b", FLOAT64)
        for i in range(count):
            log.write("/a", struct.pack("<4sd", b"\0\1\0\0", i), 10**18 + i * 10**7, i)
            log.write("/b", struct.pack("<4sd", b"\0\1\0\0", -i), 10**18 + i * 10**7 + 1, i)
    return directory


@pytest.fixture
def small_log(tmp_path: Path) -> Callable[..., Path]:
    """Write a log (`tmp_path/log` by default) with two topics of 60 messages each, ten to a chunk, and return it."""

    def make(directory: Path = tmp_path / "log", **arguments: Any) -> Path:
        return write_small_log(directory, **arguments)

    return make


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A sound file."""
    log = write_small_log(tmp_path_factory.mktemp("sound") / "log", compression="zstd")
    return (log / "log_0.mcap").read_bytes()
