"""A browser without a screen, driven over its own debugging protocol, and a dashboard whose bench the test plays."""

import asyncio
import base64
import json
import shutil
import subprocess
import threading
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import monotonic
from typing import Any, TypeVar

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.views.dashboard.access import Access
from seat_gear_dynamics.views.dashboard.board import Board
from seat_gear_dynamics.views.dashboard.scene import Scene

pytest.importorskip("aiohttp", reason="the dashboard's extra is not installed: pip install 'seat_gear_dynamics[dev]'")

import aiohttp

Result = TypeVar("Result")
Array = NDArray[np.float64]

PATIENCE = 60.0  # s; the machine may be very busy
NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--remote-debugging-port=0",
)


class Loop:
    """An event loop in a thread of its own, for tests that are written without one."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

    def run(self, work: Coroutine[Any, Any, Result]) -> Result:
        """Run a coroutine to its end and return its result."""
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(PATIENCE)

    def close(self) -> None:
        """End the loop."""
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(PATIENCE)
        self._loop.close()


class Page:
    """One tab: what it shows, what it asked the network for, and what its console said."""

    def __init__(self, loop: Loop, session: aiohttp.ClientSession, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._loop, self._session, self._socket = loop, session, socket
        self._numbers = iter(range(1, 10**9))
        self._answers: dict[int, asyncio.Future[Any]] = {}
        self.requests: list[str] = []
        self.console: list[str] = []

    async def begin(self) -> None:
        """Listen to the tab."""
        self._listening = asyncio.create_task(self._listen())
        for domain in ("Page", "Runtime", "Network", "Log"):
            await self._call(f"{domain}.enable")

    async def end(self) -> None:
        """Let go of the tab."""
        self._listening.cancel()
        await self._socket.close()
        await self._session.close()

    def do(self, method: str, **parameters: Any) -> Any:
        """Call a method of the debugging protocol."""
        return self._loop.run(self._call(method, **parameters))

    def open(self, url: str) -> None:
        """Go to an address."""
        self.do("Page.navigate", url=url)

    def value(self, expression: str) -> Any:
        """Return what an expression of the page's own language gives."""
        found = self.do("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def text(self, selector: str) -> str:
        """Return the text of an element."""
        return str(self.value(f"document.querySelector({json.dumps(selector)}).textContent"))

    def wait(self, expression: str, what: str) -> Any:
        """Wait until an expression is true, and return it."""
        begin = monotonic()
        while not (found := self.value(f"(() => {{ try {{ return {expression}; }} catch {{ return null; }} }})()")):
            assert monotonic() - begin < PATIENCE, f"waited {PATIENCE} s for {what}; it has {self.text('main')[:300]}"
            threading.Event().wait(0.05)
        return found

    def wait_text(self, selector: str, part: str) -> None:
        """Wait until an element's text contains another."""
        self.wait(
            f"document.querySelector({json.dumps(selector)}).textContent.includes({json.dumps(part)})",
            f"{part!r} in {selector}",
        )

    def click(self, selector: str) -> None:
        """Press an element with the mouse where it stands."""
        box = self.value(
            f"(() => {{ const e = document.querySelector({json.dumps(selector)});"
            f"e.scrollIntoView({{block: 'center'}});"
            f"const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})()"
        )
        for kind in ("mousePressed", "mouseReleased"):
            self.do("Input.dispatchMouseEvent", type=kind, x=box[0], y=box[1], button="left", clickCount=1)

    def key(self, name: str, code: int, text: str = "") -> None:
        """Press and let go of a key."""
        common = {"key": name, "code": name, "windowsVirtualKeyCode": code}
        self.do("Input.dispatchKeyEvent", type="keyDown", text=text, **common)
        self.do("Input.dispatchKeyEvent", type="keyUp", **common)

    def size(self, width: int, height: int, *, ratio: float = 1.0, phone: bool = False) -> None:
        """Give the page a screen."""
        self.do("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=ratio, mobile=phone)

    def dark(self, dark: bool) -> None:
        """Say what the system's theme is."""
        value = "dark" if dark else "light"
        self.do("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": value}])

    def picture(self, path: Path, *, whole: bool = False) -> None:
        """Write what is seen, or with `whole` all that scrolling shows, to a PNG file."""
        found = self.do("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(found["data"]))

    async def _call(self, method: str, **parameters: Any) -> Any:
        number = next(self._numbers)
        self._answers[number] = asyncio.get_running_loop().create_future()
        await self._socket.send_json({"id": number, "method": method, "params": parameters})
        try:
            return await asyncio.wait_for(self._answers[number], PATIENCE)
        finally:
            del self._answers[number]

    async def _listen(self) -> None:
        async for message in self._socket:
            said = json.loads(message.data)
            waiting = self._answers.get(said.get("id", 0))
            if waiting is not None and "error" in said:
                waiting.set_exception(RuntimeError(str(said["error"])))
            elif waiting is not None:
                waiting.set_result(said["result"])
            else:
                self._note(said.get("method", ""), said.get("params", {}))

    def _note(self, method: str, said: dict[str, Any]) -> None:
        if method == "Network.requestWillBeSent":
            self.requests.append(said["request"]["url"])
        elif method == "Network.webSocketCreated":
            self.requests.append(said["url"])
        elif method == "Runtime.exceptionThrown":
            self.console.append(str(said["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and said["type"] in ("error", "warning", "assert"):
            self.console.append(str(said["args"]))
        elif method == "Log.entryAdded" and said["entry"]["level"] in ("error", "warning"):
            self.console.append(said["entry"]["text"] + " " + said["entry"].get("url", ""))


@pytest.fixture(scope="session")
def browser_port(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    """A browser's debugging port."""
    program = next(filter(None, map(shutil.which, NAMES)), None)
    assert program, (
        f"The dashboard's tests drive a browser, and none of {', '.join(NAMES)} is on the path: "
        "run scripts/test, which installs Debian's chromium where it may, or apt install chromium."
    )
    folder = tmp_path_factory.mktemp("chromium")
    with (folder / "words.txt").open("wb") as words:
        process = subprocess.Popen(
            [program, *FLAGS, f"--user-data-dir={folder / 'profile'}", "about:blank"], stdout=words, stderr=words
        )
    told, begin = folder / "profile" / "DevToolsActivePort", monotonic()
    while not (told.exists() and told.read_text().count("\n")):
        said = (folder / "words.txt").read_text()
        assert process.poll() is None, f"the browser ended: {said}"
        assert monotonic() - begin < PATIENCE, f"the browser gave no port: {said}"
        threading.Event().wait(0.05)
    yield int(told.read_text().splitlines()[0])
    process.terminate()
    process.wait(PATIENCE)


@pytest.fixture
def loop() -> Iterator[Loop]:
    """A loop in a thread."""
    made = Loop()
    yield made
    made.close()


@pytest.fixture
def make_page(loop: Loop, browser_port: int) -> Iterator[Callable[[], Page]]:
    """Make tabs."""
    made: list[Page] = []

    async def make() -> Page:
        session = aiohttp.ClientSession()
        async with session.put(f"http://127.0.0.1:{browser_port}/json/new?about:blank") as answer:
            target = await answer.json()
        socket = await session.ws_connect(target["webSocketDebuggerUrl"], max_msg_size=0)
        page = Page(loop, session, socket)
        await page.begin()
        made.append(page)
        return page

    yield lambda: loop.run(make())
    for page in made:
        page.do("Page.close")
        loop.run(page.end())


@pytest.fixture
def page(make_page: Callable[[], Page]) -> Page:
    """One tab."""
    return make_page()


@dataclass
class Words:
    """A diagnostic status of the test's own."""

    name: str
    level: int
    message: str
    values: tuple[tuple[str, str], ...] = ()


@dataclass
class Played:
    """What a played bench is heard to say."""

    speed: float | None = None
    load: float | None = None
    samples: Array = field(default_factory=lambda: np.empty((0, 7)))
    windows: Array = field(default_factory=lambda: np.empty((0, 9)))
    section: Array | None = None
    warning: Words | None = None
    in_band: bool | None = None
    recorder: Words | None = None
    health: tuple[Words, ...] = ()
    ages: dict[str, float] = field(default_factory=dict)


_VALUES = {
    "speed (r/min)": "1800",
    "load (N·m)": "600",
    "band (r/min)": "1589-2060",
    "distance to band (r/min)": "-211",
    "time to band (s)": "0",
    "regime": "chaotic",
    "period": "unknown",
    "lyapunov": "0.12",
    "evidence": "the exponent is positive",
    "nearest calm speed (r/min)": "1549",
}
"""Of a chaos warning inside a band."""


class Bench:
    """A bench that the test plays: `now` is heard at each tick, rows put into `rows` once; presses are kept."""

    def __init__(self) -> None:
        self.now = Played()
        self.pressed: list[str] = []
        self.answer: Future[tuple[bool, str]] | tuple[bool, str] = (True, "done")
        self.taken = 0
        self.fault: Exception | None = None
        self._lock = threading.Lock()
        self._once: list[Played] = []

    def say(self, **changes: Any) -> None:
        """Change what is heard from now on."""
        with self._lock:
            self.now = replace(self.now, **changes)

    def run(self, rpm: float, load: float = 600.0, **changes: Any) -> None:
        """Have the bench run at a speed, every word fresh."""
        ages = dict.fromkeys(("speed", "load", "mesh", "section", "warning", "recorder"), 0.0)
        self.say(speed=rpm * RPM, load=load, ages=ages, **changes)

    def warn(self, level: int, message: str, *, in_band: bool = False, **values: str) -> None:
        """Give a warning as the monitor does, some of its values changed: `calm_speed` by the key's first letters."""
        given = dict(_VALUES)
        for name, text in values.items():
            key = name.replace("_", " ")
            given[next((known for known in given if known.startswith(key)), key)] = text
        self.say(warning=Words("gear_monitor: chaos warning", level, message, tuple(given.items())), in_band=in_band)

    def record(self, state: str, level: int = 0, **values: str) -> None:
        """Have the recorder say its state."""
        given = {"state": state, "file": "/logs/run/run_0.mcap", "written": "12345", "dropped": "0", "snapshots": "0"}
        given |= {"last snapshot": "none", "disk free (MB)": "75500", "time to full (s)": "36000"}
        given |= {key.replace("_", " "): text for key, text in values.items()}
        self.say(recorder=Words("bench_recorder: recording", level, state, tuple(given.items())))

    def status(self, name: str, level: int, message: str) -> None:
        """Add a status to the diagnostics."""
        self.say(health=(*self.now.health, Words(name, level, message)))

    def once(self, **rows: Any) -> None:
        """Have rows or a section heard once."""
        with self._lock:
            self._once.append(replace(self.now, **rows))

    def take(self) -> Played:
        """As `Source.take`."""
        with self._lock:
            if self.fault is not None:
                raise self.fault
            self.taken += 1
            return self._once.pop(0) if self._once else self.now

    def ask_recorder(self, action: str) -> "Future[tuple[bool, str]]":
        """As `Source.ask_recorder`."""
        self.pressed.append(action)
        if isinstance(self.answer, Future):
            return self.answer
        made: Future[tuple[bool, str]] = Future()
        made.set_result(self.answer)
        return made


class Served:
    """A dashboard's server on a loop of the test's own, and its bench."""

    def __init__(self, loop: Loop, bench: Bench, access: Access, scene: Scene) -> None:
        from seat_gear_dynamics.views.dashboard.server import DashboardServer

        self.bench, self._loop = bench, loop
        self.server = DashboardServer(bench, Board(scene), access)
        self.port = loop.run(self.server.start("127.0.0.1", 0))
        self.host = f"127.0.0.1:{self.port}"
        self.url = f"http://{self.host}/"

    def close(self) -> None:
        """End it."""
        self._loop.run(self.server.stop())


@pytest.fixture
def token() -> str:
    """A token that is long enough."""
    return "a-token-that-is-long-enough"


@pytest.fixture
def bench() -> Bench:
    """A bench to play."""
    return Bench()


@pytest.fixture
def scene(train: GearTrain) -> Scene:
    """The machine of fixed parameters, with its published bands."""
    return Scene(train)


@pytest.fixture
def serve(loop: Loop, bench: Bench, scene: Scene) -> Iterator[Callable[..., Served]]:
    """Make servers; keyword arguments as `Access` has them, and `host`, for which the server believes to stand."""
    made: list[Served] = []

    def make(host: str = "127.0.0.1", scene: Scene = scene, **access: Any) -> Served:
        made.append(Served(loop, bench, Access(host, **access), scene))
        return made[-1]

    yield make
    for each in made:
        if not each.server.broken:
            each.close()
