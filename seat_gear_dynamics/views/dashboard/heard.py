"""What the dashboard is given to show, and whom it asks: the shapes that its listener fills."""

from collections.abc import Mapping
from concurrent.futures import Future
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Status(Protocol):
    """A diagnostic status."""

    @property
    def name(self) -> str:
        """Who says it."""

    @property
    def level(self) -> int:
        """As DiagnosticStatus numbers levels."""

    @property
    def message(self) -> str:
        """In a sentence."""

    @property
    def values(self) -> tuple[tuple[str, str], ...]:
        """Key and text, in their order."""


class Heard(Protocol):
    """The bench as heard up to a moment; None where nothing came yet. Every number is finite and below 1e12."""

    @property
    def speed(self) -> float | None:
        """rad/s of s1, signed."""

    @property
    def load(self) -> float | None:
        """T4, N·m."""

    @property
    def samples(self) -> Array:
        """New rows (n, 7): stamp, s; δ in m, dδ/dt in m/s and force in N of s1_s2, the same of s3_s4."""

    @property
    def windows(self) -> Array:
        """New rows (n, 9): stamp, s; mean, min, max and rms force in N of s1_s2, the same of s3_s4."""

    @property
    def section(self) -> Array | None:
        """The last section points (n, 3) of s1_s2 where new ones came: δ/b_c, dimensionless rate, time in s."""

    @property
    def warning(self) -> Status | None:
        """The graded warning."""

    @property
    def in_band(self) -> bool | None:
        """The trip signal."""

    @property
    def recorder(self) -> Status | None:
        """What the recorder says of itself."""

    @property
    def health(self) -> tuple[Status, ...]:
        """What else stands in the diagnostics."""

    @property
    def ages(self) -> Mapping[str, float]:
        """s since the last `speed`, `load`, `mesh`, `section`, `warning`, `recorder`; absent where none came."""


class Source(Protocol):
    """Where the dashboard's data come from, and where a button's press goes."""

    def take(self) -> Heard:
        """Return what came since this was last called, and the latest words; at most milliseconds."""

    def ask_recorder(self, action: str) -> "Future[tuple[bool, str]]":
        """Ask the recorder to `start`, `stop` or take a `snapshot`; the future of whether it did, and its words."""
