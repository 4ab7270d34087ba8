"""How chunks are packed: codecs, and presets named as rosbag2 names its storage presets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import lz4.frame  # type: ignore[import-untyped]
import zstandard

from seat_gear_dynamics.logs.errors import LogError

Compression = Literal["zstd", "lz4", "none"]
COMPRESSIONS: tuple[Compression, ...] = ("zstd", "lz4", "none")
DEFAULT_LEVEL = 3


@dataclass(frozen=True)
class Preset:
    """What a chunk is made with: compression, zstd's level (1 to 22) and the size at which it is closed, bytes."""

    compression: Compression
    level: int
    chunk_size: int


PRESETS: Mapping[str, Preset] = {
    "none": Preset("none", DEFAULT_LEVEL, 786_432),
    "fastwrite": Preset("none", DEFAULT_LEVEL, 4_194_304),
    "zstd_fast": Preset("zstd", 1, 1_000_000),
    "zstd_small": Preset("zstd", 19, 4_194_304),
}
"""Unlike rosbag2's, each keeps chunks and checksums: without them a damaged log cannot be told from a sound one."""


def preset(name: str) -> Preset:
    """Return the preset called `name`; raises `LogError` for an unknown one."""
    try:
        return PRESETS[name]
    except KeyError as cause:
        raise LogError(f"The preset {name!r} is unknown; use one of {', '.join(PRESETS)}.") from cause


def codec(compression: str, level: int = DEFAULT_LEVEL) -> tuple[str, Callable[[bytes], bytes]]:
    """Return MCAP's name of a compression and the function that packs a chunk; raises `LogError` for an unknown one.

    `level` is zstd's, 1 (fast) to 22 (small); the other codecs do without.
    """
    if compression == "zstd":
        return "zstd", zstandard.ZstdCompressor(level=level).compress
    if compression == "lz4":
        return "lz4", lambda body: bytes(lz4.frame.compress(body))
    if compression == "none":
        return "", bytes
    raise LogError(f"The compression {compression!r} is unknown; use one of {', '.join(COMPRESSIONS)}.")
