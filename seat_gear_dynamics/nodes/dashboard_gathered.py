"""Messages of the bench to what a dashboard shows: every sample kept until it is taken, and the latest words."""

from collections import deque
from collections.abc import Callable, Sequence
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.nodes.dashboard_snapshot import Array, Snapshot, Status
from seat_gear_dynamics.nodes.messages import MESHES, nanoseconds

_ROOM = 2000  # rows that may wait for a snapshot; 40 s at the monitor's default rate
_CLOUD_ROOM = 4096  # section points of a cloud that are read
_ABSURD = 1e12  # in any unit; squares and products of what is below it stay finite
_TEXTS, _LENGTH = 40, 400  # values of a status, and characters of a text, that are kept
_SILENT = 5.0  # s; diagnostics come once a second, and a status that ceased is no longer true
_STATISTICS = ("mean", "min", "max", "rms")


class Gathered:
    """Takes messages in one thread and gives snapshots in another; `clock` gives steady time in s.

    What a message holds is checked here: a publisher that sends nonsense is not heard.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._lock = Lock()
        self._heard: dict[str, float] = {}
        self._speed: float | None = None
        self._load: float | None = None
        self._samples: deque[tuple[float, ...]] = deque(maxlen=_ROOM)
        self._windows: deque[tuple[float, ...]] = deque(maxlen=_ROOM)
        self._section: Array | None = None
        self._warning: Status | None = None
        self._in_band: bool | None = None
        self._recorder: Status | None = None
        self._health: dict[str, tuple[float, Status]] = {}

    def take(self) -> Snapshot:
        """Return what came since this was last called, and the latest words."""
        with self._lock:
            now = self._clock()
            snapshot = Snapshot(
                speed=self._speed,
                load=self._load,
                samples=_rows(self._samples, 7),
                windows=_rows(self._windows, 9),
                section=self._section,
                warning=self._warning,
                in_band=self._in_band,
                recorder=self._recorder,
                health=tuple(status for at, status in self._health.values() if now - at < _SILENT),
                ages={name: max(now - at, 0.0) for name, at in self._heard.items()},
            )
            self._samples.clear()
            self._windows.clear()
            self._section = None
        return snapshot

    def _note(self, source: str) -> None:
        self._heard[source] = self._clock()

    def on_speed(self, message: Any) -> None:
        """Take a Float64 of the speed, rad/s."""
        if _sane(message.data):
            with self._lock:
                self._speed = message.data
                self._note("speed")

    def on_load(self, message: Any) -> None:
        """Take a Float64 of the load, N·m."""
        if _sane(message.data):
            with self._lock:
                self._load = message.data
                self._note("load")

    def on_input(self, message: Any) -> None:
        """Take speed and load from what the model was fed; where the bench sends joint states nothing else has them."""
        values = (*message.velocity[:1], *message.effort[:1])
        if len(values) == 2 and all(map(_sane, values)):
            with self._lock:
                self._speed, self._load = values
                self._note("speed")
                self._note("load")

    def on_state(self, message: Any) -> None:
        """Take a JointState of `gear_monitor/mesh_state`."""
        columns = (message.position, message.velocity, message.effort)
        self._keep(self._samples, message, MESHES, columns)

    def on_force(self, message: Any) -> None:
        """Take a JointState of `gear_monitor/mesh_force`."""
        names = tuple(f"{mesh}/{statistic}" for mesh in MESHES for statistic in _STATISTICS)
        self._keep(self._windows, message, names, (message.effort,))

    def _keep(
        self, rows: deque[tuple[float, ...]], message: Any, names: Sequence[str], columns: Sequence[Sequence[float]]
    ) -> None:
        """Keep one row of the named joints' values; a message without them, or absurd, is left out."""
        place = {name: i for i, name in enumerate(message.name)}
        try:
            values = tuple(float(column[place[name]]) for name in names for column in columns)
        except (KeyError, IndexError):
            return
        if all(map(_sane, values)):
            with self._lock:
                rows.append((nanoseconds(message.header.stamp) * 1e-9, *values))
                self._note("mesh")

    def on_section(self, message: Any) -> None:
        """Take a PointCloud2 of `gear_monitor/poincare`."""
        points = section_points(message)
        if points is not None:
            with self._lock:
                self._section = points
                self._note("section")

    def on_warning(self, message: Any) -> None:
        """Take a DiagnosticStatus of `gear_monitor/chaos_warning`."""
        with self._lock:
            self._warning = _status(message)
            self._note("warning")

    def on_trip(self, message: Any) -> None:
        """Take a Bool of the trip signal."""
        with self._lock:
            self._in_band = bool(message.data)

    def on_diagnostics(self, message: Any) -> None:
        """Sort statuses by the part of the node they are of; the warning has a topic of its own."""
        with self._lock:
            for status in map(_status, message.status):
                part = status.name.rpartition(": ")[2]
                if part == "recording":
                    self._recorder = status
                    self._note("recorder")
                elif part != "warning" and (status.name in self._health or len(self._health) < _TEXTS):
                    self._health[status.name] = (self._clock(), status)


def section_points(cloud: Any) -> Array | None:
    """Return the points (n, 3) of x, y and `t` of a PointCloud2 of `gear_monitor/poincare`; None for another layout.

    The newest are kept where a cloud is larger than the page can draw; points that no bench can mean are left out.
    """
    wanted = {"x": "<f4", "y": "<f4", "t": "<f8"}
    offsets = {field.name: int(field.offset) for field in cloud.fields if field.name in wanted}
    step, size = int(cloud.point_step), len(cloud.data)
    count = int(cloud.width) * int(cloud.height)
    fits = all(offset + np.dtype(wanted[name]).itemsize <= step for name, offset in offsets.items())
    if set(offsets) != set(wanted) or cloud.is_bigendian or not fits or count * step != size:
        return None
    layout = np.dtype(
        {
            "names": list(offsets),
            "formats": [wanted[n] for n in offsets],
            "offsets": [*offsets.values()],
            "itemsize": step,
        }
    )
    stored: NDArray[Any] = np.frombuffer(bytes(cloud.data), dtype=layout)[-_CLOUD_ROOM:]
    points = np.column_stack([stored[name].astype(np.float64) for name in ("x", "y", "t")])
    return points[(np.abs(points) < _ABSURD).all(axis=1)]


def _sane(value: float) -> bool:
    """Return whether a number is finite and one that a bench can mean."""
    return abs(value) < _ABSURD  # false for NaN


def _rows(rows: deque[tuple[float, ...]], columns: int) -> Array:
    return np.array(rows, dtype=np.float64).reshape(-1, columns)


def _status(message: Any) -> Status:
    level = message.level[0] if isinstance(message.level, bytes) else int(message.level)
    values = tuple((value.key[:_LENGTH], value.value[:_LENGTH]) for value in message.values[:_TEXTS])
    return Status(message.name[:_LENGTH], level, message.message[:_LENGTH], values)
