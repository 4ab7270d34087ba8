"""The dashboard's server: the page's files and one websocket, for this machine or behind a token."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from contextlib import suppress
from weakref import WeakSet

from aiohttp import web
from aiohttp.abc import AbstractAccessLogger

from seat_gear_dynamics.views.dashboard.access import Access
from seat_gear_dynamics.views.dashboard.board import Board
from seat_gear_dynamics.views.dashboard.conversation import Conversation
from seat_gear_dynamics.views.dashboard.heard import Source
from seat_gear_dynamics.views.dashboard.page import HEADERS, read_page

RATE = 20.0
"""Frames a second."""
PAGES = 24
"""Pages that may look on at once."""
_CONNECTIONS = 96  # a page asks for its files over a few connections that last an instant
_REQUEST_PATIENCE = 10.0  # s from a connection's beginning to a whole request
_CROWD_PATIENCE = 0.5  # s; the same where there are more connections than that
_ANSWER_PATIENCE = 10.0  # s for the recorder to do what it was asked
_LINE = 4096  # bytes of a request's line, or of a header field

_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

_LOG = logging.getLogger(__name__)


class DashboardServer:
    """Serves what `source` hears at RATE; `start` and `stop` run on the loop that serves."""

    def __init__(self, source: Source, board: Board, access: Access) -> None:
        self._source, self._board, self._access = source, board, access
        self._page = read_page()
        self._conversations: WeakSet[Conversation] = WeakSet()
        self._silent: set[asyncio.BaseProtocol] = set()
        self._pressing = asyncio.Lock()

    async def start(self, host: str, port: int) -> int:
        """Listen, and return the port (that given, or a free one for 0); raises OSError where it cannot be had."""
        application = web.Application(middlewares=[self._guard], client_max_size=0)
        application.router.add_get("/live", self._live)
        for path in self._page:
            application.router.add_get(path, self._file)
        self._runner = web.AppRunner(
            application,
            access_log_class=_Silent,
            handle_signals=False,
            max_line_size=_LINE,
            max_field_size=_LINE,
            shutdown_timeout=1.0,
        )
        await self._runner.setup()
        try:
            self._listening = await asyncio.get_running_loop().create_server(self._connected, host, port)
        except OSError:
            await self._runner.cleanup()
            raise
        self._ticking = asyncio.create_task(self._tick())
        return int(self._listening.sockets[0].getsockname()[1])

    async def stop(self) -> None:
        """Tell every page goodbye and close; raises what ended the ticking if it was not this."""
        self._listening.close()
        self._ticking.cancel()
        goodbyes = [each.socket.close(code=1001, message=b"the dashboard ends") for each in self._conversations]
        with suppress(asyncio.TimeoutError):
            async with asyncio.timeout(2.0):
                await asyncio.gather(*goodbyes, return_exceptions=True)
        await self._runner.cleanup()
        with suppress(asyncio.CancelledError):
            await self._ticking

    @property
    def broken(self) -> bool:
        """Whether the picture has ceased to move."""
        return self._ticking.done()

    def _connected(self) -> asyncio.BaseProtocol:
        """Take a connection; one that says no whole request is ended in a while, and soon where there is a crowd."""
        server = self._runner.server
        assert server is not None
        protocol = server()
        self._silent.add(protocol)
        loop = asyncio.get_running_loop()
        loop.call_later(_CROWD_PATIENCE, self._end_if_crowded, protocol)
        loop.call_later(_REQUEST_PATIENCE, self._end_silent, protocol)
        return protocol

    def _end_if_crowded(self, protocol: web.RequestHandler) -> None:
        server = self._runner.server
        if server is not None and len(server.connections) > _CONNECTIONS:
            self._end_silent(protocol)

    def _end_silent(self, protocol: web.RequestHandler) -> None:
        if protocol in self._silent and protocol.transport is not None:
            protocol.transport.abort()
        self._silent.discard(protocol)

    async def _tick(self) -> None:
        loop = asyncio.get_running_loop()
        begin = due = loop.time()
        while True:
            self._board.update(self._source.take(), loop.time() - begin)
            for conversation in self._conversations:
                conversation.due.set()
            due = max(due + 1 / RATE, loop.time())  # ticks that were missed are not made up for
            await asyncio.sleep(due - loop.time())

    @web.middleware
    async def _guard(self, request: web.Request, handler: _Handler) -> web.StreamResponse:
        self._silent.discard(request.protocol)
        hosts = request.headers.getall("Host", [])
        if len(hosts) != 1 or not self._access.host_is_ours(hosts[0]):
            return self._answer(421, "This server does not go by that name.")
        try:
            response: web.StreamResponse = await handler(request)
        except web.HTTPException as refusal:
            response = self._answer(refusal.status, refusal.reason)
        if not response.prepared:
            response.headers.update(HEADERS)
            response.force_close()
        return response

    def _answer(self, status: int, text: str) -> web.Response:
        answer = web.Response(status=status, text=f"{text}\n", headers=HEADERS)
        answer.force_close()
        return answer

    async def _file(self, request: web.Request) -> web.Response:
        file = self._page[request.path]
        return web.Response(body=file.body, headers={"Content-Type": file.kind})

    async def _live(self, request: web.Request) -> web.StreamResponse:
        if not self._access.origin_is_ours(request.headers.get("Origin"), request.headers.get("Host")):
            return self._answer(403, "A page of another server may not look on.")
        if len(self._conversations) >= PAGES:
            return self._answer(503, f"{PAGES} pages look on already; close one.")
        conversation = Conversation(request, self._board, self._access, self._press)
        self._conversations.add(conversation)
        try:
            return await conversation.hold()
        finally:
            self._conversations.discard(conversation)

    async def _press(self, action: str, who: str) -> tuple[bool, str]:
        if self._pressing.locked():
            return False, "the recorder is still busy with what it was asked before"
        async with self._pressing:
            try:
                async with asyncio.timeout(_ANSWER_PATIENCE):
                    done, text = await asyncio.wrap_future(self._source.ask_recorder(action))
            except TimeoutError:
                done, text = False, f"the recorder did not answer within {_ANSWER_PATIENCE:.0f} s"
            _LOG.warning("recorder %s, asked for by %s: %s", action, who, text)
            return done, text


class _Silent(AbstractAccessLogger):
    """Requests of a page that anybody may see are not worth a line each."""

    @property
    def enabled(self) -> bool:
        """Nothing is logged."""
        return False

    def log(self, request: web.BaseRequest, response: web.StreamResponse, time: float) -> None:
        """Log nothing."""
