"""The dashboard at work: a listener that spins in one thread, a server on a loop in another."""

import asyncio
import os
import secrets
import signal
import socket
from collections.abc import Callable, Coroutine, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread
from time import monotonic
from types import FrameType, TracebackType
from typing import Any, TypeVar

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.gears import GearTrain, load_train
from seat_gear_dynamics.nodes.dashboard_listener import DashboardListener
from seat_gear_dynamics.nodes.dashboard_snapshot import Snapshot
from seat_gear_dynamics.regimes.regime_map import MapError, RegimeMap
from seat_gear_dynamics.sensing.bands import MapBands, map_path, packaged_map
from seat_gear_dynamics.views.dashboard.access import Access, AccessError, is_loopback
from seat_gear_dynamics.views.dashboard.board import Board
from seat_gear_dynamics.views.dashboard.scene import Scene

Result = TypeVar("Result")

_PATIENCE = 20.0  # s for the server to begin or to end
_LOOK = 0.5  # s between two looks at whether both threads still run


@dataclass(frozen=True)
class Settings:
    """What the dashboard is started with."""

    host: str = "127.0.0.1"
    port: int = 8642
    system: str | None = None
    map: Path | None = None
    """A regime map, or `packaged`; None: the packaged one where it is of this machine."""
    control: bool = False
    token_file: Path | None = None


class Dashboard:
    """Serves while its `with` block lasts; rclpy has to be initialised before.

    Raises CommandError, one sentence, for settings that cannot be.
    """

    def __init__(self, settings: Settings) -> None:
        train = load_train(settings.system)
        self._settings = settings
        self._token = _token(settings)
        names = () if is_loopback(settings.host) else (socket.gethostname(), socket.getfqdn())
        try:
            self._access = Access(settings.host, token=self._token, control=settings.control, names=names)
        except AccessError as error:
            raise CommandError(str(error)) from error
        self._board = Board(_scene(settings.map, train))

    def __enter__(self) -> "Dashboard":
        server_class = _server_class()
        self._node = DashboardListener(monotonic)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._spinning = Thread(target=self._spin, name="dashboard listener", daemon=True)
        self._loop = asyncio.new_event_loop()
        self._serving = Thread(target=self._loop.run_forever, name="dashboard server", daemon=True)
        self._serving.start()
        self._spinning.start()
        self._server: Any = server_class(_Ears(self._node), self._board, self._access)
        try:
            self.port = self._on_loop(self._server.start(self._settings.host, self._settings.port))
        except OSError as error:
            self._close()
            raise CommandError(
                f"The dashboard cannot listen on {self._settings.host} port {self._settings.port} "
                f"({error.strerror or error}); choose another --host or --port."
            ) from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self._on_loop(self._server.stop())
        finally:
            self._close()

    @property
    def url(self) -> str:
        """Where the page is, with the token where one is wanted."""
        host = self._settings.host
        if host in ("0.0.0.0", "::"):
            host = socket.gethostname()
        shown = f"[{host}]" if ":" in host else host
        return f"http://{shown}:{self.port}/" + (f"#token={self._token}" if self._token else "")

    def as_dict(self) -> dict[str, Any]:
        """Return where it is and what it allows."""
        return {"url": self.url, "port": self.port, "control": self._settings.control, "token": self._token}

    def words(self) -> list[str]:
        """Return the same for a person."""
        may = "the recorder may be controlled" if self._settings.control else "read-only"
        return [f"dashboard: {self.url}", f"           {may}; Ctrl-C ends it"]

    def check(self) -> None:
        """Raise CommandError if it has ceased to work by itself."""
        if not self._spinning.is_alive() or self._server.broken:
            raise CommandError("The dashboard ended by itself; what it said before tells why.")

    def _spin(self) -> None:
        with suppress(ExternalShutdownException):  # the context was shut down first: nothing is left to hear
            self._executor.spin()

    def _on_loop(self, work: Coroutine[Any, Any, Result]) -> Result:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(_PATIENCE)

    def _close(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._serving.join(_PATIENCE)
        self._executor.shutdown()
        self._spinning.join(_PATIENCE)
        self._node.destroy_node()


class _Ears:
    """The listener as the server wants its source."""

    def __init__(self, node: DashboardListener) -> None:
        self._node = node

    def take(self) -> Snapshot:
        return self._node.heard.take()

    def ask_recorder(self, action: str) -> "Future[tuple[bool, str]]":
        return self._node.ask_recorder(action)


def serve_until_told(settings: Settings, ros_args: Sequence[str], tell: Callable[[Dashboard], None]) -> None:
    """Serve until SIGINT or SIGTERM; `tell` is called once the page is there. Raises CommandError."""
    told = Event()

    def on_signal(number: int, frame: FrameType | None) -> None:
        told.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, on_signal)
    rclpy.init(args=["--ros-args", *ros_args] if ros_args else [], signal_handler_options=SignalHandlerOptions.NO)
    try:
        with Dashboard(settings) as dashboard:
            tell(dashboard)
            while not told.wait(_LOOK):
                dashboard.check()
    finally:
        rclpy.try_shutdown()


def _server_class() -> Any:
    try:
        from seat_gear_dynamics.views.dashboard.server import DashboardServer
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "aiohttp":
            raise
        raise CommandError(
            "The dashboard needs aiohttp, which is not installed: pip install 'seat_gear_dynamics[dashboard]'."
        ) from error
    return DashboardServer


def _scene(path: Path | None, train: GearTrain) -> Scene:
    if path is None:
        try:
            return _mapped_scene(packaged_map(), train)
        except (MapError, OSError):
            return Scene(train)  # the packaged map is of the packaged machine alone
    source = map_path(path)
    try:
        return _mapped_scene(source, train)
    except MapError as error:
        raise CommandError(f"{source}: {error}") from error


def _mapped_scene(path: Path, train: GearTrain) -> Scene:
    with path.open("rb") as file:
        found = RegimeMap.load(file, train)
    return Scene(train, found, map_name=path.name, map_bands=MapBands(found, train))


def _token(settings: Settings) -> str | None:
    """Return the token: that of the file, a new one where one is wanted, or None."""
    path = settings.token_file
    wanted = settings.control or not is_loopback(settings.host) or path is not None
    if not wanted:
        return None
    if path is None:
        return secrets.token_urlsafe(32)
    try:
        return path.read_text(encoding="utf-8").strip()
    except FileNotFoundError:
        made = secrets.token_urlsafe(32)
        # Nobody else may read it, not even for the moment between making and closing it to them.
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(f"{made}\n")
        return made
    except UnicodeDecodeError as error:
        raise CommandError(f"The token file {path} is no text; remove it, and a new one is made.") from error
