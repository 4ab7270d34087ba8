"""What the live view shows, as plain values."""

from collections import deque
from dataclasses import dataclass, field

from seat_gear_dynamics.views.warning_said import PUBLISHED, band_said, source_said


@dataclass
class MeshStatistics:
    """Force statistics of one mesh over the last window, N."""

    mean: float
    min: float
    max: float
    rms: float


@dataclass
class LiveState:
    """The bench as last heard; None where nothing came yet. Filled by a listener, read by the view."""

    title: str
    bands_rpm: tuple[tuple[float, float], ...]
    """The published bands."""
    covered_rpm: float
    load_scale: float
    duration: float | None = None
    """Length of the run, s; None for an open end."""
    ending: str = "Ctrl-C ends the run, completes the log and writes the report"
    """What ends an open run, in words."""
    elapsed: float = 0.0
    speed_rpm: float | None = None
    load: float | None = None
    meshes: dict[str, MeshStatistics] = field(default_factory=dict)
    level: int = 3
    reason: str = "waiting for the monitor"
    in_band: bool = False
    details: dict[str, str] = field(default_factory=dict)
    """Values of the warning by key, as published."""
    recorder: dict[str, str] = field(default_factory=dict)
    """Values of the recorder's diagnostics by key."""
    solver: str = ""
    history: deque[tuple[float, float, int]] = field(default_factory=lambda: deque(maxlen=600))
    """(elapsed s, |speed| r/min, level), a few a second."""

    @property
    def by_published_bands(self) -> bool:
        """Whether the monitor goes by the published bands, as far as is known."""
        return source_said(self.details) == PUBLISHED

    @property
    def forbidden_rpm(self) -> tuple[tuple[float, float], ...]:
        """The bands to show: of a monitor that goes by a map only the nearest is known, as its warning says it."""
        if self.by_published_bands:
            return self.bands_rpm
        nearest = band_said(self.details)
        return () if nearest is None else (nearest,)
