"""A server that stops: what its vehicles hear."""

import asyncio
from pathlib import Path

from websockets.asyncio.client import connect

from contract.wire.close_reasons import retry_after
from contract.wire.codec import decode_from_server
from contract.wire.messages import Goodbye
from tests.campusloop.live.live_server import live_server, obedient_vehicle


def test_vehicles_hear_that_the_server_leaves_and_may_dial_again_at_once(tmp_path: Path) -> None:
    async def scenario() -> None:
        async with live_server(tmp_path) as server, obedient_vehicle(server) as vehicle:
            server.stop()
            async with asyncio.timeout(10):
                while not isinstance(vehicle.heard[-1], Goodbye):  # noqa: ASYNC110 - it comes over a socket
                    await asyncio.sleep(0.01)
            goodbye = vehicle.heard[-1]
            assert isinstance(goodbye, Goodbye)
            assert goodbye.code == "server_leaving"
            assert retry_after(goodbye.code) == "at_once"

    asyncio.run(scenario())


def test_a_connection_that_has_not_said_hello_hears_it_too(tmp_path: Path) -> None:
    async def scenario() -> None:
        async with (
            live_server(tmp_path) as server,
            connect(server.origin.replace("http", "ws", 1) + "/ws/vehicle", proxy=None) as connection,
        ):
            await connection.recv()
            server.stop()
            async with asyncio.timeout(10):
                said = decode_from_server(await connection.recv())
            assert isinstance(said, Goodbye)
            assert said.code == "server_leaving"

    asyncio.run(scenario())
