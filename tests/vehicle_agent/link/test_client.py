"""The shell around the session, over real sockets on this machine: it dials, tells, and dials again."""

import asyncio
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from pathlib import Path

import pytest
from structlog.testing import capture_logs
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from contract.wire.codec import decode_from_vehicle, encode
from contract.wire.messages import (
    Challenge,
    Command,
    CommandDone,
    EventReport,
    Goodbye,
    Hello,
    OrderProgress,
    Welcome,
)
from vehicle_agent.link.bridge import LinkBridge, TickUpdate
from vehicle_agent.link.client import LinkClient
from vehicle_agent.link.redial import FIRST_WAIT_S, Redial
from vehicle_agent.link.session import Identity
from vehicle_agent.signals import LinkMessage, LinkState

ME = Identity("shuttle-1", "boot-1", "0.1", "gem", "map-1", 6, 1)
WITHIN_S = 10.0


class Campus:
    """A server that welcomes whoever dials, and the vehicle's link to it."""

    def __init__(self, folder: Path) -> None:
        self.hellos: list[Hello] = []
        self.events: list[EventReport] = []
        self.delivered: list[LinkMessage] = []
        self.sockets: list[ServerConnection] = []
        self.now_ns = 0
        self.desk = LinkBridge(folder, ME, lambda text: "", sync=False)
        self.client: LinkClient
        self.running: asyncio.Task[None]

    async def serve(self, socket: ServerConnection) -> None:
        self.sockets.append(socket)
        await socket.send(encode(Challenge("nonce", 1, 1, 5)).decode())
        try:
            async for data in socket:
                message = decode_from_vehicle(data)
                if isinstance(message, Hello):
                    self.hellos.append(message)
                    await socket.send(encode(Welcome(len(self.hellos), 1, 5)).decode())
                elif isinstance(message, EventReport):
                    self.events.append(message)
        except ConnectionClosed:
            return

    @property
    def link_states(self) -> list[bool]:
        return [word.connected for word in self.delivered if isinstance(word, LinkState)]

    async def until(self, condition: Callable[[], bool]) -> None:
        async with asyncio.timeout(WITHIN_S):
            while not condition():  # noqa: ASYNC110 - what is waited for comes over a socket
                await asyncio.sleep(0.01)


def with_campus(folder: Path, claim: Callable[[Campus], Awaitable[None]]) -> None:
    async def scenario() -> None:
        campus = Campus(folder)
        async with serve(campus.serve, "127.0.0.1", 0) as server:
            port = server.sockets[0].getsockname()[1]
            campus.client = LinkClient(
                f"ws://127.0.0.1:{port}", campus.desk, campus.delivered.append, lambda: campus.now_ns
            )
            running = campus.running = asyncio.create_task(campus.client.run())
            try:
                await campus.until(lambda: campus.link_states == [True])
                await claim(campus)
            finally:
                running.cancel()
                await asyncio.gather(running, return_exceptions=True)
        campus.desk.close()

    asyncio.run(scenario())


def test_what_happens_is_told_as_soon_as_the_desk_is_woken(tmp_path: Path) -> None:
    async def claim(campus: Campus) -> None:
        campus.desk.process_update(TickUpdate(1, events=(CommandDone("c", True),)), 1)
        campus.client.wake()
        await campus.until(lambda: len(campus.events) == 1)
        assert campus.events[0].body == CommandDone("c", True)
        assert len(campus.hellos) == 1, "nothing was dialled anew for it"

    with_campus(tmp_path, claim)


def test_what_the_server_says_reaches_the_vehicle_in_order(tmp_path: Path) -> None:
    async def claim(campus: Campus) -> None:
        said = [Command(1, "one", "hold"), Command(1, "two", "resume")]
        for command in said:
            await campus.sockets[0].send(encode(command).decode())
        await campus.until(lambda: len(campus.delivered) >= 3)
        assert campus.delivered[1:] == said

    with_campus(tmp_path, claim)


def test_a_cut_is_told_to_the_vehicle_and_the_server_is_dialled_again(tmp_path: Path) -> None:
    async def claim(campus: Campus) -> None:
        campus.desk.process_update(TickUpdate(1, events=(CommandDone("c", True),)), 1)
        campus.sockets[0].transport.abort()
        await campus.until(lambda: campus.link_states == [True, False, True])
        await campus.until(lambda: any(event.epoch == 2 for event in campus.events))

    with_campus(tmp_path, claim)


def test_dialling_anew_on_purpose_tells_what_the_vehicle_holds_by_then(tmp_path: Path) -> None:
    async def claim(campus: Campus) -> None:
        progress = OrderProgress("order-1", 2, ())
        campus.desk.process_update(TickUpdate(1, memory=b"order", progress=progress), 1)
        campus.client.reconnect()
        await campus.until(lambda: len(campus.hellos) == 2)
        assert [hello.progress for hello in campus.hellos] == [None, progress]
        await asyncio.sleep(0.3)
        assert len(campus.hellos) == 2, "once is enough"

    with_campus(tmp_path, claim)


def test_a_server_that_falls_silent_is_given_up_for_a_new_connection(tmp_path: Path) -> None:
    async def claim(campus: Campus) -> None:
        campus.now_ns = 26_000_000_000
        campus.client.wake()
        await campus.until(lambda: len(campus.hellos) == 2)

    with_campus(tmp_path, claim)


def test_a_frame_that_is_no_message_ends_the_connection_and_not_the_link(tmp_path: Path) -> None:
    async def claim(campus: Campus) -> None:
        await campus.sockets[0].send('{"type":"teleport"}')
        await campus.until(lambda: len(campus.hellos) == 2)

    with_campus(tmp_path, claim)


def test_a_goodbye_is_no_reason_to_stop_trying(tmp_path: Path) -> None:
    async def claim(campus: Campus) -> None:
        await campus.sockets[0].send(encode(Goodbye("superseded", "another boot speaks")).decode())
        await campus.sockets[0].close()
        await campus.until(lambda: len(campus.hellos) == 2)

    with_campus(tmp_path, claim)


def test_a_proxy_that_answers_for_an_absent_server_is_dialled_again(tmp_path: Path) -> None:
    """As during an upgrade of the server: the proxy in front of it answers with an HTTP error."""
    refusals = 0

    def refused_once(connection: ServerConnection, _request: Request) -> Response | None:
        nonlocal refusals
        refusals += 1
        return connection.respond(HTTPStatus.BAD_GATEWAY, "no server") if refusals == 1 else None

    async def scenario() -> None:
        campus = Campus(tmp_path)
        async with serve(campus.serve, "127.0.0.1", 0, process_request=refused_once) as server:
            port = server.sockets[0].getsockname()[1]
            campus.client = LinkClient(
                f"ws://127.0.0.1:{port}", campus.desk, campus.delivered.append, lambda: 0
            )
            running = campus.running = asyncio.create_task(campus.client.run())
            await campus.until(lambda: campus.link_states[-1:] == [True])
            assert refusals == 2
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    asyncio.run(scenario())


def test_an_address_that_is_none_is_logged_and_tried_ever_less_often(tmp_path: Path) -> None:
    async def scenario() -> None:
        campus = Campus(tmp_path)
        client = LinkClient(
            "https:/nowhere", campus.desk, campus.delivered.append, lambda: 0, redial=Redial(lambda: 1.0)
        )
        with capture_logs() as logs:
            running = asyncio.create_task(client.run())
            await campus.until(lambda: len(logs) == 2)
        assert [(entry["event"], entry["url"], entry["retry_s"]) for entry in logs] == [
            ("link.unreachable", "https:/nowhere", FIRST_WAIT_S),
            ("link.unreachable", "https:/nowhere", 2.0 * FIRST_WAIT_S),
        ]
        assert not running.done()
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)

    asyncio.run(scenario())


def test_a_sender_with_a_defect_ends_the_link_instead_of_a_link_that_only_listens(tmp_path: Path) -> None:
    async def claim(campus: Campus) -> None:
        def defect(now_ns: int) -> None:
            raise ZeroDivisionError("defect")

        campus.desk.session.advance = defect  # type: ignore[method-assign]
        campus.client.wake()
        async with asyncio.timeout(WITHIN_S):
            with pytest.raises(ZeroDivisionError):
                await campus.running

    with_campus(tmp_path, claim)
