"""The server against a hostile or clumsy other side: what it gives out, to whom, and whom it lets go."""

import asyncio
import json
import re
import select
import socket
from collections.abc import Callable, Coroutine
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

import pytest

pytest.importorskip("aiohttp")

import aiohttp

from seat_gear_dynamics.views.dashboard import conversation, server
from seat_gear_dynamics.views.dashboard.page import HEADERS, read_page

PATIENCE = 30.0  # s; the machine may be very busy


def raw(served: Any, request: bytes) -> bytes:
    """Send bytes as they are and return all that comes until the other side ends."""
    with socket.create_connection(("127.0.0.1", served.port), timeout=PATIENCE) as link:
        link.sendall(request)
        answer = b""
        while part := link.recv(65536):
            answer += part
    return answer


def asked(served: Any, path: str, *, host: str | None = None, more: str = "", method: str = "GET") -> tuple[int, str]:
    """Return status and whole text of an answer."""
    host = f"Host: {served.host}\r\n" if host is None else host
    answer = raw(served, f"{method} {path} HTTP/1.1\r\n{host}{more}\r\n".encode()).decode(errors="replace")
    return int(answer.split(" ")[1]), answer


async def greeted(session: aiohttp.ClientSession, served: Any, token: str = "") -> aiohttp.ClientWebSocketResponse:
    """Begin a conversation as the page does."""
    socket_ = await session.ws_connect(f"{served.url}live", headers={"Origin": f"http://{served.host}"})
    await socket_.send_json({"token": token})
    return socket_


def talk(loop: Any, work: Callable[[aiohttp.ClientSession], Coroutine[Any, Any, Any]]) -> Any:
    """Run a conversation with a session of its own."""

    async def run() -> Any:
        async with aiohttp.ClientSession() as session:
            return await asyncio.wait_for(work(session), PATIENCE)

    return loop.run(run())


async def closing(link: aiohttp.ClientWebSocketResponse) -> tuple[int | None, str]:
    """Return code and reason with which the other side ends, whatever it says before."""
    while True:
        message = await link.receive()
        if message.type == aiohttp.WSMsgType.CLOSE:
            return message.data, str(message.extra)
        if message.type != aiohttp.WSMsgType.TEXT:
            return link.close_code, ""


async def heard(link: aiohttp.ClientWebSocketResponse, kind: str) -> dict[str, Any]:
    """Return the next message of a kind."""
    while True:
        said: dict[str, Any] = await link.receive_json()
        if said["kind"] == kind:
            return said


def test_the_page_and_all_it_names_are_given_out_with_strict_headers(serve: Any) -> None:
    served = serve()
    status, page = asked(served, "/")
    assert status == 200
    named = set(re.findall(r'(?:src|href)="([^"#]+)"', page))
    imports = {name for text in read_page().values() for name in re.findall(rb'from "\./([^"]+)"', text.body)}
    assert len(named) > 5
    assert len(imports) > 5
    for path in [*named, *(name.decode() for name in imports)]:
        status, answer = asked(served, f"/{path}")
        assert status == 200, path
        for name, value in HEADERS.items():
            assert f"{name}: {value}\r\n" in answer
    policy = HEADERS["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert "*" not in policy


def test_nothing_on_the_page_needs_another_host_or_an_exception_to_the_policy() -> None:
    for path, file in read_page().items():
        if "vendor" in path:
            continue
        text = file.body.decode()
        addresses = set(re.findall(r"(?:https?|wss?)://[^\s\"'`]+", text)) - {"http://www.w3.org/2000/svg"}
        assert all("${" in address for address in addresses), (path, addresses)
        assert not re.search(r"\son\w+=|style=|javascript:|innerHTML|outerHTML|insertAdjacentHTML|eval\(", text), path


@pytest.mark.parametrize(
    "path",
    [
        "/../setup.py",
        "/..%2f..%2fsetup.py",
        "/%2e%2e/%2e%2e/setup.py",
        "/vendor/../../board.py",
        "/vendor/..\\..\\board.py",
        "//etc/passwd",
        "/etc/passwd",
        "/style.css/../../board.py",
        "/style.css%00.png",
        "/style.css;x",
        "/%ff%fe",
        "/board.py",
        "/page/index.html",
        "/" + "a" * 3000,
    ],
)
def test_there_is_no_way_out_of_the_table_of_files(serve: Any, path: str) -> None:
    status, answer = asked(serve(), path)
    assert status in (400, 403, 404)
    assert "import " not in answer
    assert "root:" not in answer


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH"])
def test_there_is_nothing_to_write_to(serve: Any, method: str) -> None:
    assert asked(serve(), "/", method=method)[0] in (400, 405)
    assert asked(serve(), "/live", method=method)[0] in (400, 405)


@pytest.mark.parametrize(
    "host",
    [
        "",
        "Host: evil.example\r\n",
        "Host: localhost.evil.example\r\n",
        "Host: \r\n",
        "Host: 10.1.2.3\r\n",
        "Host: localhost\r\nHost: evil.example\r\n",
    ],
    ids=["none", "foreign", "look-alike", "empty", "another address", "two"],
)
def test_a_page_under_another_name_gets_nothing(serve: Any, host: str) -> None:
    status, answer = asked(serve(), "/", host=host)
    assert status in (400, 421)
    assert "<html" not in answer


@pytest.mark.parametrize(
    "path", ["/%0d%0aSet-Cookie:%20a=b", "/x%0aX-Injected:%20y", "/\x0b", "/?q=%0d%0aX-Injected:%20y"]
)
def test_nothing_that_is_asked_for_gets_into_the_headers(serve: Any, path: str) -> None:
    _, answer = asked(serve(), path, more="X-Forwarded-Host: evil.example\r\n")
    head = answer.partition("\r\n\r\n")[0]
    for word in ("Set-Cookie", "X-Injected", "evil.example"):
        assert word not in head


@pytest.mark.parametrize(
    "request_",
    [
        b"GET / HTTP/1.1\r\nHost: localhost\r\nX: a\rSet-Cookie: b\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\nContent-Length: 6\r\n\r\nhello",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"a" * 20000 + b"\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(64) + b"\r\n\r\n",
        b"GET\r\n\r\n",
    ],
    ids=["bare return", "two lengths", "a header without end", "tls", "half a line"],
)
def test_what_is_no_request_is_refused(serve: Any, request_: bytes) -> None:
    assert b" 400 " in raw(serve(), request_).split(b"\r\n")[0]


@pytest.mark.parametrize(
    "origin",
    [None, "http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1", "http://{host}.evil.example"],
)
def test_a_foreign_page_may_not_look_on(serve: Any, loop: Any, origin: str | None) -> None:
    served = serve()
    headers = {} if origin is None else {"Origin": origin.format(host=served.host)}

    async def work(session: aiohttp.ClientSession) -> int:
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await session.ws_connect(f"{served.url}live", headers=headers)
        return refused.value.status

    assert talk(loop, work) == 403


def test_a_page_is_greeted_and_then_gets_frames(serve: Any, loop: Any, bench: Any) -> None:
    served = serve()
    bench.run(1800)

    async def work(session: aiohttp.ClientSession) -> None:
        link = await greeted(session, served)
        hello = await link.receive_json()
        assert (hello["kind"], hello["role"]) == ("hello", "watch")
        first, second = await heard(link, "frame"), await heard(link, "frame")
        assert first["fresh"] is True
        assert second["tick"] > first["tick"]
        assert second["now"]["speed"] == 1800

    talk(loop, work)


@pytest.mark.parametrize(
    "text",
    ["{", "[]", "3", '"token"', "null", "{}", '{"token": 3}', "[" * 2000, '{"token": NaN', "\x00"],
)
def test_a_greeting_that_is_none_ends_the_conversation(serve: Any, loop: Any, text: str) -> None:
    served = serve()

    async def work(session: aiohttp.ClientSession) -> tuple[int | None, str]:
        link = await session.ws_connect(f"{served.url}live", headers={"Origin": f"http://{served.host}"})
        await link.send_str(text)
        return await closing(link)

    code, reason = talk(loop, work)
    assert code == 1008
    assert "expected a JSON object" in reason or "has no token" in reason


def test_bytes_and_messages_without_end_are_refused(serve: Any, loop: Any) -> None:
    served = serve()

    async def work(session: aiohttp.ClientSession) -> list[int | None]:
        codes = []
        for data in (b"\xff\xfe", json.dumps({"token": "x" * 5000}).encode()):
            link = await session.ws_connect(f"{served.url}live", headers={"Origin": f"http://{served.host}"})
            await (link.send_bytes(data) if len(data) < 10 else link.send_str(data.decode()))
            codes.append((await closing(link))[0])
        return codes

    assert talk(loop, work) == [1008, 1009]


def test_a_page_that_never_greets_is_let_go(serve: Any, loop: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conversation, "_GREETING_PATIENCE", 0.05)
    served = serve()

    async def work(session: aiohttp.ClientSession) -> tuple[int | None, str]:
        return await closing(await session.ws_connect(f"{served.url}live", headers={"Origin": f"http://{served.host}"}))

    assert talk(loop, work) == (1008, "no greeting came")


@pytest.mark.parametrize("given", ["", "wrong-but-just-as-long-a-token"])
def test_away_from_this_machine_nothing_is_shown_without_the_token(
    serve: Any, loop: Any, token: str, given: str
) -> None:
    served = serve("0.0.0.0", token=token)

    async def work(session: aiohttp.ClientSession) -> tuple[int | None, str]:
        link = await greeted(session, served, given)
        message = await link.receive()
        assert message.type == aiohttp.WSMsgType.CLOSE, "not a word before it"
        return message.data, str(message.extra)

    assert talk(loop, work) == (4401, "the token is missing or wrong")


def test_a_press_reaches_the_recorder_and_its_answer_comes_back(serve: Any, loop: Any, bench: Any, token: str) -> None:
    served = serve(token=token, control=True)
    bench.answer = (True, "482 messages in /logs/run_snapshot1")

    async def work(session: aiohttp.ClientSession) -> dict[str, Any]:
        link = await greeted(session, served, token)
        assert (await heard(link, "hello"))["role"] == "control"
        await link.send_json({"press": "snapshot"})
        return await heard(link, "answer")

    answer = talk(loop, work)
    assert answer == {
        "kind": "answer",
        "press": "snapshot",
        "done": True,
        "text": "482 messages in /logs/run_snapshot1",
    }
    assert bench.pressed == ["snapshot"]


@pytest.mark.parametrize("control", [False, True])
def test_who_may_only_watch_presses_nothing(serve: Any, loop: Any, bench: Any, token: str, control: bool) -> None:
    served = serve(token=token, control=control)

    async def work(session: aiohttp.ClientSession) -> tuple[int | None, str]:
        link = await greeted(session, served, "" if control else token)
        assert (await heard(link, "hello"))["role"] == "watch"
        await link.send_json({"press": "stop"})
        return await closing(link)

    assert talk(loop, work) == (1008, "this page may only watch")
    assert bench.pressed == []


@pytest.mark.parametrize("press", ["shutdown", "start; rm", "", None, 3, ["start"], {"start": 1}])
def test_a_press_that_is_none_ends_the_conversation(serve: Any, loop: Any, bench: Any, token: str, press: Any) -> None:
    served = serve(token=token, control=True)

    async def work(session: aiohttp.ClientSession) -> int | None:
        link = await greeted(session, served, token)
        await link.send_json({"press": press})
        return (await closing(link))[0]

    assert talk(loop, work) == 1008
    assert bench.pressed == []


def test_one_press_at_a_time_and_a_recorder_that_does_not_answer(
    serve: Any, loop: Any, bench: Any, token: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    served = serve(token=token, control=True)
    never: Future[tuple[bool, str]] = Future()
    bench.answer = never

    async def work(session: aiohttp.ClientSession) -> tuple[dict[str, Any], dict[str, Any]]:
        first, second = await greeted(session, served, token), await greeted(session, served, token)
        await first.send_json({"press": "stop"})
        while not bench.pressed:
            await heard(first, "frame")
        await second.send_json({"press": "stop"})
        busy = await heard(second, "answer")
        never.set_result((True, "stopped"))
        return busy, await heard(first, "answer")

    busy, done = talk(loop, work)
    assert busy["done"] is False
    assert "busy" in busy["text"]
    assert done["text"] == "stopped"
    assert bench.pressed == ["stop"]
    monkeypatch.setattr(server, "_ANSWER_PATIENCE", 0.05)
    bench.answer = Future()

    async def again(session: aiohttp.ClientSession) -> dict[str, Any]:
        link = await greeted(session, served, token)
        await link.send_json({"press": "stop"})
        return await heard(link, "answer")

    assert "did not answer" in talk(loop, again)["text"]


def test_no_more_pages_than_the_server_means_to_serve(serve: Any, loop: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "PAGES", 2)
    served = serve()

    async def work(session: aiohttp.ClientSession) -> int:
        links = [await greeted(session, served) for _ in range(2)]
        for link in links:
            await heard(link, "frame")
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await greeted(session, served)
        await links[0].close()
        while True:  # the place is free once the server has seen the goodbye
            try:
                await heard(await greeted(session, served), "frame")
                return refused.value.status
            except aiohttp.WSServerHandshakeError:
                await heard(links[1], "frame")

    assert talk(loop, work) == 503


def test_a_page_that_reads_nothing_is_let_go_and_holds_nobody_up(
    serve: Any, loop: Any, bench: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(conversation, "_SEND_PATIENCE", 0.3)
    served = serve()
    bench.run(1800)
    # Frames of some hundred kilobytes, so that no system's buffers swallow them.
    bench.warn(2, "x" * 300_000)
    with socket.socket() as deaf:
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.settimeout(PATIENCE)
        deaf.connect(("127.0.0.1", served.port))
        key = "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
        upgrade = (
            f"Host: {served.host}\r\nOrigin: http://{served.host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        )
        deaf.sendall(f"GET /live HTTP/1.1\r\n{upgrade}{key}\r\n".encode())
        deaf.sendall(b"\x81\x8c\x00\x00\x00\x00" + b'{"token":""}')  # masked with zeros

        async def work(session: aiohttp.ClientSession) -> None:
            link = await greeted(session, served)
            await heard(link, "frame")
            while len(served.server._conversations) > 1:
                await heard(link, "frame")

        talk(loop, work)


def test_a_connection_that_says_nothing_or_half_a_request_is_ended(serve: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "_REQUEST_PATIENCE", 0.2)
    served = serve()
    for half in (b"", b"GET / HTTP/1.1\r\nHost: loc"):
        with socket.create_connection(("127.0.0.1", served.port), timeout=PATIENCE) as link:
            link.sendall(half)
            with suppress(ConnectionResetError):
                assert link.recv(1) == b""


def test_a_crowd_of_connections_is_cut_off_and_the_page_still_served(
    serve: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "_CONNECTIONS", 5)
    served = serve()
    crowd = [socket.create_connection(("127.0.0.1", served.port), timeout=PATIENCE) for _ in range(6)]
    try:
        ended, _, _ = select.select(crowd, [], [], PATIENCE)
        assert ended, "of six silent ones some are too many"
    finally:
        for link in crowd:
            link.close()
    while True:  # the places are free once the server has seen them go
        try:
            assert asked(served, "/")[0] == 200
            return
        except (ConnectionResetError, IndexError):
            continue


def test_a_source_that_fails_is_not_passed_over(serve: Any, loop: Any, bench: Any) -> None:
    served = serve()
    bench.fault = RuntimeError("no more")

    async def ended() -> None:
        while not served.server.broken:
            await asyncio.sleep(0.01)

    loop.run(asyncio.wait_for(ended(), PATIENCE))
    with pytest.raises(RuntimeError, match="no more"):
        served.close()
