"""The soak's clock and links: simulated vehicles in real time."""

import asyncio

import pytest
from websockets.asyncio.server import ServerConnection, serve

from benchmarks.fleet_soak.real_link import RealNetwork
from benchmarks.fleet_soak.real_schedule import RealSchedule
from campusloop.simulation.schedule import VehicleEnd

WITHIN_S = 10.0


def test_actions_run_in_the_order_in_which_they_are_due() -> None:
    async def ran() -> list[str]:
        schedule, done, found = RealSchedule(1), asyncio.Event(), list[str]()

        def end() -> None:
            found.append("later")
            done.set()

        schedule.after(0.05, end)
        schedule.at(schedule.now_ns - 10**9, lambda: found.append("at once"))
        async with asyncio.timeout(WITHIN_S):
            await done.wait()
        return found

    assert asyncio.run(ran()) == ["at once", "later"]


def test_a_named_stream_of_chance_is_the_same_for_the_same_seed() -> None:
    async def drawn(seed: int, name: str) -> float:
        return RealSchedule(seed).rng(name).random()

    assert asyncio.run(drawn(1, "doors")) == asyncio.run(drawn(1, "doors"))
    assert asyncio.run(drawn(1, "doors")) != asyncio.run(drawn(1, "network"))


class Vehicle:
    """Dials, and remembers what it hears and how its connections end."""

    def __init__(self, network: RealNetwork) -> None:
        self.heard: list[bytes] = []
        self.ends: list[str] = []
        self.end: VehicleEnd | None = None
        self.opened = asyncio.Event()
        self.closed = asyncio.Event()
        network.dial("shuttle-01", self._opened)

    def _opened(self, end: VehicleEnd | None) -> None:
        self.end = end
        if end is not None:
            end.listen(self.heard.append, self._closed)
        self.opened.set()

    def _closed(self, reason: str) -> None:
        self.ends.append(reason)
        self.closed.set()


async def _echo(socket: ServerConnection) -> None:
    async for frame in socket:
        await socket.send(frame)


def test_frames_go_both_ways_and_a_cut_is_noticed_once() -> None:
    async def spoken() -> Vehicle:
        async with serve(_echo, "127.0.0.1", 0) as server:
            port = next(iter(server.sockets)).getsockname()[1]
            network = RealNetwork(f"ws://127.0.0.1:{port}")
            vehicle = Vehicle(network)
            async with asyncio.timeout(WITHIN_S):
                await vehicle.opened.wait()
                assert vehicle.end is not None
                vehicle.end.send(b"a")
                vehicle.end.send(b"b")
                while len(vehicle.heard) < 2:  # noqa: ASYNC110 - it comes over a socket
                    await asyncio.sleep(0.01)
                assert network.cut("shuttle-01")
                await vehicle.closed.wait()
            vehicle.end.send(b"nobody hears this")
            await network.close()
        return vehicle

    vehicle = asyncio.run(spoken())
    assert vehicle.heard == [b"a", b"b"]
    assert len(vehicle.ends) == 1


def test_a_vehicle_that_says_goodbye_is_told_of_no_end() -> None:
    async def left() -> tuple[Vehicle, list[int]]:
        codes = list[int]()

        async def keep(socket: ServerConnection) -> None:
            await socket.wait_closed()
            codes.append(socket.close_code or 0)

        async with serve(keep, "127.0.0.1", 0) as server:
            port = next(iter(server.sockets)).getsockname()[1]
            network = RealNetwork(f"ws://127.0.0.1:{port}")
            vehicle = Vehicle(network)
            async with asyncio.timeout(WITHIN_S):
                await vehicle.opened.wait()
                assert vehicle.end is not None
                vehicle.end.close(1002, "no message of this protocol")
                while not codes:  # noqa: ASYNC110 - it comes over a socket
                    await asyncio.sleep(0.01)
            await network.close()
        return vehicle, codes

    vehicle, codes = asyncio.run(left())
    assert vehicle.ends == []
    assert codes == [1000]


@pytest.mark.parametrize("url", ["ws://127.0.0.1:9"])
def test_a_server_that_is_not_there_is_no_connection(url: str) -> None:
    async def dialled() -> Vehicle:
        network = RealNetwork(url)
        vehicle = Vehicle(network)
        async with asyncio.timeout(WITHIN_S):
            await vehicle.opened.wait()
        await network.close()
        return vehicle

    assert asyncio.run(dialled()).end is None
