"""A developer's requests: rides, vehicles, commands and closures."""

import asyncio
import sys
from datetime import UTC, datetime
from pathlib import Path

import pytest

from campusloop_sdk import Conflict, ConnectionLost, Invalid, NotAllowed, NotFound, connect
from contract.wire.messages import Command, Order
from tests.campusloop.live.live_server import LiveServer, obedient_vehicle
from tests.sdk.campus_scripts import against_server
from tests.sdk.cutting_proxy import cutting_proxy

EXAMPLE = Path(__file__).resolve().parents[2] / "sdk" / "python" / "examples" / "send_shuttle.py"


def test_a_script_lists_sends_holds_and_resumes_a_shuttle(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server) as vehicle, connect(server.origin, secret) as campus:
            assert {stop.stop_id async for stop in campus.stops()} >= {"NN7", "C6"}
            (shuttle,) = [one async for one in campus.vehicles.list()]
            assert (shuttle.vehicle_id, shuttle.connected) == ("shuttle-1", True)
            sent = await campus.vehicles.send("shuttle-1", "C6")
            assert sent.last_visit_to("C6") is not None
            for command in (
                await campus.vehicles.hold("shuttle-1", for_s=600.0),
                await campus.vehicles.resume("shuttle-1"),
                await campus.vehicles.announce("shuttle-1", "We wait for a van."),
                await campus.vehicles.stop_now("shuttle-1"),
            ):
                assert command.state == "pending"
            async with asyncio.timeout(5):
                while len([m for m in vehicle.heard if isinstance(m, Command)]) < 4:  # noqa: ASYNC110
                    await asyncio.sleep(0.05)
            kinds = [message.kind for message in vehicle.heard if isinstance(message, Command)]
            assert kinds == ["hold", "resume", "announce", "stop_now"]
            assert any(isinstance(message, Order) for message in vehicle.heard)
            assert not (await campus.vehicles.recall("shuttle-1")).in_service
            assert (await campus.vehicles.release("shuttle-1")).in_service

    against_server(tmp_path, claim)


def test_a_ride_has_ranges_and_seats_and_a_look_stores_nothing(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server), connect(server.origin, secret) as campus:
            offer = await campus.rides.look("NN20", "C6", party=2)
            assert (offer.is_free, offer.rule) == (True, "")
            assert [ride async for ride in campus.rides.list()] == []
            ride = await campus.rides.book("NN20", "C6", party=2)
            assert ride.pickup_earliest is not None
            assert ride.pickup_latest is not None
            assert ride.pickup_eta is not None
            assert ride.pickup_earliest <= ride.pickup_eta <= ride.pickup_latest
            assert ride.seats_left is not None
            assert ride.vehicle_name
            (found,) = [one async for one in campus.rides.list(ride_code=ride.ride_code)]
            assert (found.ride_id, found.feedback) == (ride.ride_id, None)

    against_server(tmp_path, claim)


def test_a_dry_run_of_send_says_when_and_changes_nothing(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server) as vehicle, connect(server.origin, secret) as campus:
            before = await campus.vehicles.get("shuttle-1")
            tried = await campus.vehicles.send("shuttle-1", "C6", dry_run=True)
            visit = tried.last_visit_to("C6")
            assert visit is not None
            assert visit.eta is not None
            assert visit.eta > datetime.now(UTC)
            after = await campus.vehicles.get("shuttle-1")
            assert (after.plan_version, after.visits) == (before.plan_version, before.visits)
            assert not any(isinstance(message, Order) for message in vehicle.heard)

    against_server(tmp_path, claim)


def test_a_script_books_lists_redirects_and_cancels_a_ride(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server), connect(server.origin, secret) as campus:
            booked = await campus.rides.book("NN20", "C6", party=2)
            assert (booked.state, booked.party, booked.vehicle_id) == ("assigned", 2, "shuttle-1")
            assert booked.promise is not None
            # The vehicle may be at the stop by now.
            assert (await campus.rides.get(booked.ride_id)).state in ("assigned", "boarding")
            redirected = await campus.rides.change_destination(booked.ride_id, "NN7")
            assert redirected.to_stop == "NN7"
            cancelled = await campus.rides.cancel(booked.ride_id)
            assert (cancelled.state, cancelled.reason) == ("cancelled", "cancelled_by_developer")
            assert [one.ride_id async for one in campus.rides.list(["cancelled"])] == [booked.ride_id]
            assert [one async for one in campus.rides.list(["assigned"])] == []

    against_server(tmp_path, claim)


def test_a_list_is_complete_whatever_the_length_of_its_pages(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with connect(server.origin, secret) as campus:
            booked = [(await campus.rides.book("NN20", "C6")).ride_id for _ in range(5)]
            for page in (1, 2, 5, 200):
                listed = [ride.ride_id async for ride in campus.rides.list(page=page)]
                assert listed == booked[::-1]

    against_server(tmp_path, claim)


def test_a_script_closes_and_opens_a_road(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        lane_id = (await server.http.get("/campus/map")).json()["lanes"][0]["lane_id"]
        async with connect(server.origin, secret) as campus:
            closed = await campus.closures.close([lane_id], reason="water main")
            assert closed.made_by == "developer:test"
            assert [one.closure_id async for one in campus.closures.list()] == [closed.closure_id]
            await campus.closures.lift(closed.closure_id)
            assert [one async for one in campus.closures.list()] == []

    against_server(tmp_path, claim)


def test_a_command_with_the_same_key_is_carried_out_once(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server), connect(server.origin, secret) as campus:
            first = await campus.vehicles.send("shuttle-1", "C6", key="morning-run-1")
            again = await campus.vehicles.send("shuttle-1", "C6", key="morning-run-1")
            assert again == first
            with pytest.raises(Conflict) as refusal:
                await campus.vehicles.send("shuttle-1", "NN7", key="morning-run-1")
            assert refusal.value.code == "idempotency_mismatch"

    against_server(tmp_path, claim)


def test_a_booking_whose_answer_was_lost_is_made_once(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with cutting_proxy(server.origin) as proxy, connect(proxy.origin, secret) as campus:
            proxy.answers_to_lose = 2
            booked = await campus.rides.book("NN20", "C6")
            assert proxy.connections == 3
            assert [ride.ride_id async for ride in campus.rides.list()] == [booked.ride_id]

    against_server(tmp_path, claim)


def test_without_any_answer_the_connection_is_lost(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read")
        async with cutting_proxy(server.origin) as proxy, connect(proxy.origin, secret) as campus:
            proxy.is_shut = True
            with pytest.raises(ConnectionLost, match="5 attempts"):
                await campus.vehicles.get("shuttle-1")

    against_server(tmp_path, claim)


def test_a_refusal_has_a_type_and_the_code_of_the_server(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server), connect(server.origin, secret) as campus:
            with pytest.raises(NotFound) as unknown:
                await campus.vehicles.send("shuttle-1", "the-moon")
            assert (unknown.value.code, unknown.value.status) == ("stop_unknown", 404)
            with pytest.raises(NotFound, match="vehicle_unknown"):
                await campus.vehicles.hold("shuttle-9")
            with pytest.raises(Invalid) as invalid:
                await campus.rides.book("NN20", "C6", party=0)
            assert [field.where for field in invalid.value.fields] == ["body.party"]

    against_server(tmp_path, claim)


def test_a_token_does_what_its_scopes_allow(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        reading, token_id = await server.developer_token("read")
        driving, _ = await server.developer_token("drive")
        async with connect(server.origin, reading) as campus:
            assert [one async for one in campus.vehicles.list()] == []
            with pytest.raises(NotAllowed, match="scope_missing"):
                await campus.rides.book("NN20", "C6")
            await server.change("DELETE", f"/developer-tokens/{token_id}")
            with pytest.raises(NotAllowed, match="token_invalid"):
                await campus.rides.get("ride-1")
        async with connect(server.origin, driving) as campus:
            assert (await campus.rides.book("NN20", "C6")).state == "refused"
            with pytest.raises(NotAllowed, match="scope_missing"):
                await campus.rides.get("ride-1")

    against_server(tmp_path, claim)


@pytest.mark.parametrize("more", [(), ("--vehicle", "shuttle-1")])
def test_the_example_sends_a_shuttle_and_follows_it_until_it_is_there(
    tmp_path: Path, more: tuple[str, ...]
) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server):
            text = await run_example(secret, server.origin, "--stop", "C6", *more)
        assert "shuttle-1 will visit C6" in text
        assert "visit under_way" in text

    against_server(tmp_path, claim)


def test_the_example_lists_the_stops_and_says_what_it_would_do(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server):
            assert "C6" in await run_example(secret, server.origin, "--list")
            text = await run_example(secret, server.origin, "--stop", "C6", "--dry-run")
        assert "shuttle-1 would visit C6" in text

    against_server(tmp_path, claim)


async def run_example(secret: str, *arguments: str) -> str:
    paths = [path for path in sys.path if path]
    script = await asyncio.create_subprocess_exec(
        sys.executable,
        str(EXAMPLE),
        *arguments,
        env={
            "CAMPUSLOOP_TOKEN": secret,
            "PATH": "",
            "NO_PROXY": "*",
            "PYTHONPATH": ":".join(paths),
        },
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
    )
    output, _ = await script.communicate()
    assert script.returncode == 0, output.decode()
    return output.decode()
