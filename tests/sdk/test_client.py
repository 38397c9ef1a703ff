"""A developer's script against the real server: websockets, threads, files and all."""

import asyncio
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from campusloop_sdk import Campus, ConnectionLost, Notification, RequestRefused, connect
from contract.wire.messages import Command, Order
from tests.campusloop.live.live_server import LiveServer, live_server, obedient_vehicle

EXAMPLE = Path(__file__).resolve().parents[2] / "sdk" / "python" / "examples" / "send_shuttle.py"


def against_server(tmp_path: Path, claim: Callable[[LiveServer], Awaitable[None]]) -> None:
    async def run() -> None:
        async with asyncio.timeout(40), live_server(tmp_path) as server:
            await claim(server)

    asyncio.run(run())


async def first_notification(campus: Campus, topic: str) -> Notification:
    async for notification in campus.notifications():
        if notification.topic == topic:
            return notification
    raise AssertionError("the notification ended")


def test_a_script_lists_sends_follows_pauses_and_resumes_a_shuttle(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server) as vehicle, connect(server.origin, secret) as campus:
            assert {stop.stop_id for stop in await campus.list_stops()} >= {"NN7", "C6"}
            assert await campus.subscribe("events", "vehicles") == ["events", "vehicles"]
            sent = await campus.send_to_stop("shuttle-1", "C6")
            async with asyncio.timeout(10):
                notification = await first_notification(campus, "events")
                while notification.params["body"]["event"] != "visit_changed":
                    notification = await first_notification(campus, "events")
            assert notification.params["body"]["visit_id"] == sent.visit_id
            assert any(isinstance(message, Order) for message in vehicle.heard)
            (shuttle,) = await campus.list_vehicles()
            assert (shuttle.vehicle_id, shuttle.facts.connected) == ("shuttle-1", True)
            assert shuttle.status is not None
            await campus.pause("shuttle-1")
            await campus.resume("shuttle-1")
            async with asyncio.timeout(5):
                while len([m for m in vehicle.heard if isinstance(m, Command)]) < 2:  # noqa: ASYNC110
                    await asyncio.sleep(0.05)
            kinds = [message.kind for message in vehicle.heard if isinstance(message, Command)]
            assert kinds[:2] == ["hold", "resume"]
            assert await campus.unsubscribe("events") == ["vehicles"]

    against_server(tmp_path, claim)


def test_a_script_sees_rides_and_is_refused_by_name(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read")
        async with obedient_vehicle(server), connect(server.origin, secret) as campus:
            await campus.subscribe("rides")
            ride = {"from_stop": "NN20", "to_stop": "C6", "party": 2}
            booked = (await server.http.post("/rides", json=ride)).json()
            async with asyncio.timeout(5):
                notification = await first_notification(campus, "rides")
            assert notification.params["rides"][0]["ride_id"] == booked["ride_id"]
            assert [(ride.party, ride.from_stop) for ride in await campus.list_rides()] == [(2, "NN20")]
            with pytest.raises(RequestRefused, match="drive") as refusal:
                await campus.send_to_stop("shuttle-1", "C6")
            assert refusal.value.number == -32001

    against_server(tmp_path, claim)


def test_what_cannot_be_done_comes_back_with_its_code(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server), connect(server.origin, secret) as campus:
            for vehicle_id, stop_id, code in (
                ("shuttle-1", "the-moon", "stop_unknown"),
                ("shuttle-9", "C6", "vehicle_unknown"),
            ):
                with pytest.raises(RequestRefused) as refusal:
                    await campus.send_to_stop(vehicle_id, stop_id)
                assert refusal.value.code == code

    against_server(tmp_path, claim)


def test_a_wrong_token_opens_nothing_and_a_revoked_one_ends(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        with pytest.raises(ConnectionLost, match="token_invalid"):
            async with connect(server.origin, "not-a-token") as campus:
                await campus.list_stops()
        secret, token_id = await server.developer_token("read")
        async with connect(server.origin, secret) as campus:
            assert await campus.list_vehicles() == []
            await server.change("DELETE", f"/developer-tokens/{token_id}")
            with pytest.raises(ConnectionLost, match="token_invalid"):
                await campus.list_vehicles()

    against_server(tmp_path, claim)


def test_the_example_sends_a_shuttle_and_follows_it_until_it_is_there(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server):
            script = await asyncio.create_subprocess_exec(
                sys.executable,
                str(EXAMPLE),
                server.origin,
                "--stop",
                "C6",
                env={"CAMPUSLOOP_TOKEN": secret, "PATH": "", "NO_PROXY": "*"},
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.STDOUT,
            )
            output, _ = await script.communicate()
        text = output.decode()
        assert script.returncode == 0, text
        assert "shuttle-1 will visit C6" in text
        assert "visit under_way" in text

    against_server(tmp_path, claim)
