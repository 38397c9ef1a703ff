"""A developer's live subscription: a snapshot, changes, and a lost connection that is opened again."""

import asyncio
import random
from itertools import islice
from pathlib import Path

import pytest

from campusloop_sdk import EventUpdate, NotAllowed, RidesUpdate, VehiclesUpdate, connect
from campusloop_sdk.backoff import FIRST_S, LONGEST_S, pauses
from tests.campusloop.live.live_server import LiveServer, obedient_vehicle
from tests.sdk.campus_scripts import against_server, until
from tests.sdk.cutting_proxy import cutting_proxy


def test_a_subscription_begins_with_a_snapshot_and_goes_on_with_changes(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with obedient_vehicle(server), connect(server.origin, secret) as campus:
            booked = await campus.rides.book("NN20", "C6")
            async with campus.live("rides", "vehicles") as live:
                first = await until(live, lambda update: isinstance(update, RidesUpdate))
                assert isinstance(first, RidesUpdate)
                assert first.snapshot
                await until(live, lambda _: booked.ride_id in live.rides)
                await until(live, lambda _: "shuttle-1" in live.vehicles)
                await campus.rides.cancel(booked.ride_id)
                change = await until(live, lambda _: live.rides[booked.ride_id].state == "cancelled")
                assert isinstance(change, RidesUpdate)
                assert not change.snapshot

    against_server(tmp_path, claim)


def test_a_topic_that_is_added_later_begins_with_its_snapshot(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read")
        async with (
            obedient_vehicle(server),
            connect(server.origin, secret) as campus,
            campus.live("rides") as live,
        ):
            await until(live, lambda update: isinstance(update, RidesUpdate))
            await live.subscribe("vehicles")
            added = await until(live, lambda update: isinstance(update, VehiclesUpdate))
            assert isinstance(added, VehiclesUpdate)
            assert added.snapshot
            await live.unsubscribe("vehicles")
            assert set(live.vehicles) == {"shuttle-1"}

    against_server(tmp_path, claim)


def test_what_happens_while_the_connection_is_cut_is_in_the_next_snapshot(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with (
            cutting_proxy(server.origin) as proxy,
            connect(proxy.origin, secret) as campus,
            campus.live("rides") as live,
        ):
            await until(live, lambda _: True)
            proxy.is_shut = True
            proxy.cut()
            ride = {"from_stop": "NN20", "to_stop": "C6"}
            booked = (await server.http.post("/rides", json=ride)).json()["ride_id"]
            asyncio.get_running_loop().call_later(1.0, setattr, proxy, "is_shut", False)
            again = await until(live, lambda _: booked in live.rides)
            assert isinstance(again, RidesUpdate)
            assert proxy.connections == 2

    against_server(tmp_path, claim)


def test_events_come_as_the_vehicle_reported_them(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        secret, _ = await server.developer_token("read", "drive")
        async with (
            obedient_vehicle(server),
            connect(server.origin, secret) as campus,
            campus.live("events") as live,
        ):
            sent = (await campus.vehicles.send("shuttle-1", "C6")).last_visit_to("C6")
            assert sent is not None
            event = await until(live, lambda _: True)
            assert isinstance(event, EventUpdate)
            assert (event.vehicle_id, event.body["event"]) == ("shuttle-1", "visit_changed")
            assert event.body["visit_id"] == sent.visit_id

    against_server(tmp_path, claim)


def test_a_wrong_token_opens_no_subscription_and_a_revoked_one_does_not_resume(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        async with connect(server.origin, "not-a-token") as campus:
            with pytest.raises(NotAllowed, match="token_invalid"):
                async with campus.live("rides"):
                    pass
        secret, token_id = await server.developer_token("read")
        async with (
            cutting_proxy(server.origin) as proxy,
            connect(proxy.origin, secret) as campus,
            campus.live("rides") as live,
        ):
            await until(live, lambda _: True)
            await server.change("DELETE", f"/developer-tokens/{token_id}")
            proxy.cut()
            with pytest.raises(NotAllowed, match="token_invalid"):
                await until(live, lambda _: False)

    against_server(tmp_path, claim)


def test_pauses_grow_are_bounded_and_differ_between_scripts() -> None:
    first, second = (list(islice(pauses(random.Random(seed)), 60)) for seed in (1, 2))
    assert first != second
    assert all(0.0 <= pause_s <= LONGEST_S for pause_s in first)
    assert max(first[:2]) <= 2 * FIRST_S
    assert max(first[10:]) > LONGEST_S / 2
