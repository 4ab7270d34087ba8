"""One page's conversation: a greeting with the token, then frames out and, where allowed, presses of buttons in."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from seat_gear_dynamics.views.dashboard.access import Access, Role
from seat_gear_dynamics.views.dashboard.board import Board, Cursor

MESSAGE_BYTES = 2048
"""The most that a page may say at once."""
TOKEN_WANTED = 4401
"""Close code: the token is missing or wrong."""
_GREETING_PATIENCE = 5.0  # s for the greeting
_SEND_PATIENCE = 5.0  # s; a page that takes no frame for so long is let go
_HEARTBEAT = 10.0  # s between pings

Press = Callable[[str, str], Awaitable[tuple[bool, str]]]
"""(action, who) to whether it was done, and what was said."""


class Refused(Exception):  # noqa: N818
    """What a page said cannot be taken; the text goes into the closing of its conversation."""

    def __init__(self, text: str, code: int = WSCloseCode.POLICY_VIOLATION) -> None:
        super().__init__(text)
        self.code = code


class Conversation:
    """Speaks with one page over a websocket until either side ends it."""

    def __init__(self, request: web.Request, board: Board, access: Access, press: Press) -> None:
        self._request, self._board, self._access, self._press = request, board, access, press
        # Frames are small and many: compressing them would cost more than it saves.
        self.socket = web.WebSocketResponse(max_msg_size=MESSAGE_BYTES, heartbeat=_HEARTBEAT, compress=False)
        self.due = asyncio.Event()
        """Set at each tick; a page that is behind misses ticks and gets their samples with the next frame."""

    async def hold(self) -> web.WebSocketResponse:
        """Hold the conversation and return its response."""
        await self.socket.prepare(self._request)
        try:
            role = await self._greet()
            await self._say({"kind": "hello", "role": role, "scene": self._board.scene.description()})
            frames = asyncio.create_task(self._send_frames())
            try:
                await self._hear(role)
            finally:
                frames.cancel()
                with suppress(asyncio.CancelledError, ConnectionError):
                    await frames
        except Refused as refusal:
            await self.socket.close(code=refusal.code, message=str(refusal).encode()[:120])
        except TimeoutError:
            self.abort()
        except ConnectionError:
            pass  # the page went while it was spoken to
        return self.socket

    async def _greet(self) -> Role:
        try:
            message = await self.socket.receive(timeout=_GREETING_PATIENCE)
        except TimeoutError:
            raise Refused("no greeting came") from None
        said = _parsed(message.type, message.data)
        token = said.get("token")
        if not isinstance(token, str):
            raise Refused("the greeting has no token, not even an empty one")
        role = self._access.role(token)
        if role is None:
            raise Refused("the token is missing or wrong", TOKEN_WANTED)
        return role

    async def _send_frames(self) -> None:
        cursor = Cursor()
        while True:
            self.due.clear()  # before the frame is made: a tick that comes while it is sent is one more
            text, cursor = self._board.frame(cursor)
            try:
                # Not wait_for: Python 3.11's can lose a cancellation, and this would then go on for ever.
                async with asyncio.timeout(_SEND_PATIENCE):
                    await self.socket.send_str(text)
            except TimeoutError:
                self.abort()
                return
            await self.due.wait()

    async def _hear(self, role: Role) -> None:
        async for message in self.socket:
            said = _parsed(message.type, message.data)
            action = said.get("press")
            if role != "control":
                raise Refused("this page may only watch")
            if action not in ("start", "stop", "snapshot"):
                raise Refused("a press is one of start, stop and snapshot")
            done, text = await self._press(action, str(self._request.remote))
            await self._say({"kind": "answer", "press": action, "done": done, "text": text})

    async def _say(self, what: dict[str, Any]) -> None:
        async with asyncio.timeout(_SEND_PATIENCE):
            await self.socket.send_str(json.dumps(what, allow_nan=False))

    def abort(self) -> None:
        """End the connection without waiting for anything more from the other side."""
        if self._request.transport is not None:
            self._request.transport.abort()


def _parsed(kind: WSMsgType, data: Any) -> dict[str, Any]:
    """Return what a page said; raises Refused for anything but a JSON object."""
    if kind in (WSMsgType.CLOSE, WSMsgType.CLOSING, WSMsgType.CLOSED, WSMsgType.ERROR):
        raise ConnectionResetError
    try:
        said = json.loads(data) if kind == WSMsgType.TEXT else None
    except (ValueError, RecursionError):
        said = None
    if not isinstance(said, dict):
        raise Refused("expected a JSON object")
    return said
