"""The demo's cameras: from the simulation's datagrams to the server's socket, also after it was away."""

import asyncio
import socket
from pathlib import Path

import httpx
import msgspec
import pytest
from websockets.asyncio.server import ServerConnection, serve

from campusloop.clients.demo_cameras import DemoCameras, camera_token
from campusloop.clients.operator_client import OperatorClient
from campusloop.crossing_cameras import report_link
from contract.wire.messages import PresenceReport
from simulator.control import CameraReported, RiderLeft, Subscribe, decode_to_simulation, encode

HOST = "127.0.0.1"


class Server:
    """Takes the reports of one connection, and closes it after some."""

    def __init__(self, closes_after: int) -> None:
        self.heard: list[PresenceReport] = []
        self.tokens: list[str | None] = []
        self.paths: list[str] = []
        self._closes_after = closes_after
        self.enough = asyncio.Event()

    async def take(self, connection: ServerConnection) -> None:
        assert connection.request is not None
        self.paths.append(connection.request.path)
        self.tokens.append(connection.request.headers.get("Authorization"))
        taken = 0
        async for message in connection:
            self.heard.append(msgspec.json.decode(message, type=PresenceReport))
            taken += 1
            if len(self.heard) >= 2 * self._closes_after:
                self.enough.set()
            if taken == self._closes_after:
                return


async def forwarded() -> tuple[Server, list[str]]:
    """A simulation that says something 50 times a second, and a server that hangs up after 3 reports."""
    said: list[str] = []
    simulation = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    simulation.bind((HOST, 0))
    simulation.setblocking(False)
    server = Server(closes_after=3)
    async with serve(server.take, HOST, 0) as listening:
        port = listening.sockets[0].getsockname()[1]
        cameras = DemoCameras(
            f"http://{HOST}:{port}", "secret", None, simulation.getsockname()[1], said.append
        )
        running = asyncio.create_task(cameras.run())
        loop = asyncio.get_running_loop()
        data, subscriber = await asyncio.wait_for(loop.sock_recvfrom(simulation, 1000), 5.0)
        assert isinstance(decode_to_simulation(data), Subscribe)

        async def tell() -> None:
            count = 0
            while True:
                simulation.sendto(encode(RiderLeft("ride-1")), subscriber)
                simulation.sendto(encode(CameraReported("crossing-1", count, 0.2)), subscriber)
                count += 1
                await asyncio.sleep(0.02)

        telling = asyncio.create_task(tell())
        await asyncio.wait_for(server.enough.wait(), 10.0)
        for task in (telling, running):
            task.cancel()
        await asyncio.gather(telling, running, return_exceptions=True)
    simulation.close()
    return server, said


def test_reports_reach_the_server_with_the_token_and_again_after_it_was_away(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(report_link, "REDIAL_S", 0.05)
    server, said = asyncio.run(forwarded())
    assert set(server.tokens) == {"Bearer secret"}
    assert set(server.paths) == {"/ws/infrastructure"}
    assert len(server.paths) >= 2
    assert {report.area_id for report in server.heard} == {"crossing-1"}
    counts = [report.count for report in server.heard]
    assert counts == sorted(counts)
    assert any("cannot reach" in text for text in said)


def test_cameras_wait_for_a_server_that_gives_them_no_token_yet() -> None:
    """The demo used to end when its cameras were refused, with all rides under way."""
    answers = [
        httpx.Response(429, json={"title": "Too many requests", "detail": "try again in 2 s"}),
        httpx.Response(201, json={"secret": "s3cret"}),
    ]
    said: list[str] = []

    async def ask() -> str:
        transport = httpx.MockTransport(lambda _request: answers.pop(0))
        async with httpx.AsyncClient(transport=transport, base_url="http://server") as client:
            return await camera_token(OperatorClient(client), said.append, every_s=0.0)

    assert asyncio.run(ask()) == "s3cret"
    assert len(said) == 1
    assert "Too many requests" in said[0]
