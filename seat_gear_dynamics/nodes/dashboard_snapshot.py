"""What the dashboard's listener has heard, as plain values: samples since the last snapshot, and the latest words."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SOURCES = ("speed", "load", "mesh", "section", "warning", "recorder")
"""Kinds of word whose age a snapshot gives."""


@dataclass(frozen=True)
class Status:
    """A diagnostic status: who says it, level as DiagnosticStatus numbers it, text, and values in their order."""

    name: str
    level: int
    message: str
    values: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Snapshot:
    """The bench as heard up to a moment; None where nothing came yet."""

    speed: float | None
    """rad/s of s1, signed."""
    load: float | None
    """T4, N·m."""
    samples: Array
    """New rows (n, 7): stamp, s; then δ in m, dδ/dt in m/s and force in N of s1_s2, the same of s3_s4."""
    windows: Array
    """New rows (n, 9): stamp, s; then mean, min, max and rms force in N of s1_s2, the same of s3_s4."""
    section: Array | None
    """The last section points (n, 3) of s1_s2: δ/b_c, dimensionless rate, time in s; None where no new cloud came."""
    warning: Status | None
    in_band: bool | None
    """The trip signal."""
    recorder: Status | None
    health: tuple[Status, ...]
    """What else stands in the diagnostics of the last seconds, the latest of each name."""
    ages: Mapping[str, float]
    """s since the last word, by the names in SOURCES; a source that never spoke is not there."""
