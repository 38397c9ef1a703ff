"""/ws/live against the real server, as browsers open it."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from tests.campusloop.live.live_server import LiveServer, live_server, obedient_vehicle


def against_server(tmp_path: Path, claim: Callable[[LiveServer], Awaitable[None]]) -> None:
    async def run() -> None:
        async with asyncio.timeout(40), live_server(tmp_path) as server:
            await claim(server)

    asyncio.run(run())


def view(server: LiveServer, signed_in: bool = False, origin: str | None = None) -> Any:
    headers = (
        {"Cookie": f"campusloop_session={server.http.cookies['campusloop_session']}"} if signed_in else {}
    )
    url = server.origin.replace("http", "ws", 1) + "/ws/live"
    return connect(url, additional_headers=headers, origin=origin, proxy=None)  # type: ignore[arg-type]


async def told(connection: ClientConnection) -> dict[str, Any]:
    message: dict[str, Any] = json.loads(await connection.recv())
    return message


async def refusal(connection: ClientConnection) -> tuple[str, int]:
    """The refusal's code and the close code after it."""
    message = await told(connection)
    assert message["type"] == "refused"
    assert message["detail"]
    with pytest.raises(ConnectionClosed) as closed:
        await connection.recv()
    assert closed.value.rcvd is not None
    return message["code"], closed.value.rcvd.code


def test_an_operator_sees_everything_and_then_what_changes(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        async with obedient_vehicle(server), view(server, signed_in=True) as connection:
            await connection.send('{"type":"watch"}')
            first = await told(connection)
            assert first["type"] == "snapshot"
            assert [vehicle["vehicle_id"] for vehicle in first["scene"]["vehicles"]] == ["shuttle-1"]
            ride = {"from_stop": "NN20", "to_stop": "C6"}
            booked = (await server.http.post("/rides", json=ride)).json()
            rides: list[dict[str, Any]] = []
            async with asyncio.timeout(10):
                while not rides:
                    news = await told(connection)
                    assert news["type"] == "delta"
                    rides = news["rides"]
            assert rides[0]["ride_code"] == booked["ride_code"]

    against_server(tmp_path, claim)


def test_a_passenger_sees_the_own_ride_and_its_shuttle(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        async with obedient_vehicle(server):
            ride = {"from_stop": "NN20", "to_stop": "C6"}
            mine = (await server.http.post("/rides", json=ride)).json()
            await server.http.post("/rides", json={"from_stop": "C6", "to_stop": "NN7"})
            await asyncio.sleep(0.3)
            async with view(server) as connection:
                await connection.send(json.dumps({"type": "watch", "ride_token": mine["token"]}))
                scene = (await told(connection))["scene"]
        assert [ride["ride_id"] for ride in scene["rides"]] == [mine["ride_id"]]
        assert [vehicle["vehicle_id"] for vehicle in scene["vehicles"]] == ["shuttle-1"]
        assert scene["incidents"]["open"] == 0

    against_server(tmp_path, claim)


def test_strangers_and_other_sites_see_nothing(tmp_path: Path) -> None:
    async def claim(server: LiveServer) -> None:
        async with view(server) as stranger:
            await stranger.send('{"type":"watch"}')
            assert await refusal(stranger) == ("session_expired", 4403)
        async with view(server) as guesser:
            await guesser.send('{"type":"watch","ride_token":"AAAAAAAAAAAAAAAAAAAAAAAA"}')
            assert await refusal(guesser) == ("ride_unknown", 4403)
        async with view(server, signed_in=True, origin="https://evil.example") as other:
            assert await refusal(other) == ("other_origin", 4403)
        async with view(server, signed_in=True, origin=server.origin) as ours:
            await ours.send('{"type":"watch"}')
            assert (await told(ours))["type"] == "snapshot"

    against_server(tmp_path, claim)


@pytest.mark.parametrize("frame", ["nonsense", "{}", '{"type":"steal"}', "[" * 50_000, b"\x00\xff"])
def test_a_first_frame_that_is_no_watch_is_refused(tmp_path: Path, frame: str | bytes) -> None:
    async def claim(server: LiveServer) -> None:
        async with view(server) as connection:
            await connection.send(frame)
            assert await refusal(connection) == ("malformed", 4400)

    against_server(tmp_path, claim)
