"""Senders that take too much room or time, against a real socket of uvicorn."""

import asyncio
import socket
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
import uvicorn
from websockets.asyncio.client import connect

from campusloop.live.connections import bounded_http
from campusloop.live.connections.bounded_http import HEAD_BYTES_MAX, counted_protocols
from server.api.security import connection_counts
from server.api.security.connection_counts import ConnectionCounts

HEAD = b"POST / HTTP/1.1\r\nhost: campus\r\n"
ENOUGH_S = 20.0

Claim = Callable[[int], Awaitable[None]]


async def app(scope: dict[str, Any], receive: Any, send: Any) -> None:
    """Answers how many bytes the body has; a websocket sends each text back."""
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
        while (message := await receive())["type"] != "websocket.disconnect":
            if message["type"] == "websocket.receive":
                await send({"type": "websocket.send", "text": message["text"]})
        return
    size, more = 0, True
    while more:
        message = await receive()
        size += len(message.get("body", b""))
        more = message.get("more_body", False)
    text = str(size).encode()
    await send(
        {"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"%d" % len(text))]}
    )
    await send({"type": "http.response.body", "body": text})


def with_server(claim: Claim, counts: ConnectionCounts | None = None) -> None:
    http, websocket = counted_protocols(counts or ConnectionCounts(1_000))

    async def run() -> None:
        config = uvicorn.Config(app, http=http, ws=websocket, lifespan="off", log_level="error")
        server = uvicorn.Server(config)
        with socket.create_server(("127.0.0.1", 0)) as listening:
            serving = asyncio.create_task(server.serve(sockets=[listening]))
            async with asyncio.timeout(ENOUGH_S):
                await claim(listening.getsockname()[1])
            server.should_exit = True
            await serving

    asyncio.run(run())


async def answer_to(port: int, *pieces: bytes) -> bytes:
    """Everything that comes back until the server closes; the sender keeps its side open."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        for piece in pieces:
            writer.write(piece)
            await writer.drain()
            await asyncio.sleep(0.05)
        return await reader.read()
    except ConnectionResetError:
        return b""
    finally:
        writer.close()


async def sent_before_refusal(port: int, line: bytes) -> int:
    """How many bytes of an endless head were sent until the connection was closed."""
    _, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(HEAD)
    for count in range(1000):
        try:
            writer.write(line)
            await writer.drain()
        except ConnectionError:
            return count * len(line)
        await asyncio.sleep(0.01)
    pytest.fail("an endless head was taken")


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounded_http, "HEAD_WITHIN_S", 0.3)
    monkeypatch.setattr(bounded_http, "BODY_PAUSE_S_MAX", 0.3)


@pytest.mark.parametrize("line", [b"x-pad: " + 8_000 * b"p" + b"\r\n", 8_000 * b"p"])
def test_an_endless_head_is_refused_after_some_of_it(line: bytes) -> None:
    async def claim(port: int) -> None:
        assert await sent_before_refusal(port, line) < 20 * HEAD_BYTES_MAX

    with_server(claim)


@pytest.mark.usefixtures("hasty")
@pytest.mark.parametrize("said", [b"", HEAD, b"GET / HT"])
def test_a_sender_that_does_not_finish_its_head_is_let_go(said: bytes) -> None:
    async def claim(port: int) -> None:
        assert (await answer_to(port, said)).startswith(b"HTTP/1.1 408 ")

    with_server(claim)


@pytest.mark.usefixtures("hasty")
def test_a_body_that_stops_is_given_up() -> None:
    async def claim(port: int) -> None:
        assert b" 408 " in await answer_to(port, HEAD + b"content-length: 100\r\n\r\nhalf")

    with_server(claim)


@pytest.mark.usefixtures("hasty")
def test_a_body_that_keeps_coming_is_taken_however_long_it_takes() -> None:
    async def claim(port: int) -> None:
        head = HEAD + b"content-length: 40\r\nconnection: close\r\n\r\n"
        answer = await answer_to(port, head, *(10 * [b"half"]))
        assert answer.startswith(b"HTTP/1.1 200 ")
        assert answer.endswith(b"40")

    with_server(claim)


def test_a_large_body_in_one_piece_with_its_head_is_no_large_head() -> None:
    async def claim(port: int) -> None:
        body = 4 * HEAD_BYTES_MAX * b"b"
        head = HEAD + b"connection: close\r\ncontent-length: %d\r\n\r\n" % len(body)
        assert (await answer_to(port, head + body)).endswith(str(len(body)).encode())

    with_server(claim)


@pytest.mark.usefixtures("hasty")
def test_a_websocket_may_be_silent_for_longer() -> None:
    async def claim(port: int) -> None:
        async with connect(f"ws://127.0.0.1:{port}/") as websocket:
            await asyncio.sleep(1.0)
            await websocket.send("still here")
            assert await websocket.recv() == "still here"

    with_server(claim)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> ConnectionCounts:
    """Two connections for each client, also on loopback."""
    monkeypatch.setattr(connection_counts, "LOOPBACK", ())
    return ConnectionCounts(2)


def test_a_connection_too_many_is_closed_and_another_is_taken_when_one_has_ended(
    counted: ConnectionCounts,
) -> None:
    async def claim(port: int) -> None:
        async with connect(f"ws://127.0.0.1:{port}/") as websocket:
            _, writer = await asyncio.open_connection("127.0.0.1", port)
            assert await answer_to(port, HEAD + b"\r\n") == b""
            await websocket.send("still here")
            assert await websocket.recv() == "still here"
            writer.close()
            await writer.wait_closed()
            await until_ended(counted, 1)
            answer = await answer_to(port, HEAD + b"connection: close\r\ncontent-length: 0\r\n\r\n")
            assert answer.startswith(b"HTTP/1.1 200 ")
        await until_ended(counted, 0)

    with_server(claim, counted)


async def until_ended(counts: ConnectionCounts, left: int) -> None:
    for _ in range(500):
        if counts._open.total() == left:
            return
        await asyncio.sleep(0.01)
    pytest.fail(f"{counts._open.total()} connections are counted, not {left}")
