"""Riders in a running simulation: the demo's client of `simulator.control`."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Any, Literal

from campusloop.clients.passengers import RideDemand
from contract.geometry import Pose2
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from simulator.control import (
    RideAssigned,
    RiderComes,
    RiderTapped,
    Subscribe,
    ToSimulation,
    decode_from_simulation,
    encode,
)

HOST = "127.0.0.1"
SUBSCRIBE_EVERY_S = 5.0

Tap = Callable[[str, Literal["board", "alight"]], Awaitable[None]]


class SimulatedPeople:
    """A rider port for a world in another process."""

    def __init__(self, road_map: RoadMap, port: int) -> None:
        """port: the simulation's control port on the loopback."""
        self._network = RoadNetwork(road_map)
        self._stops = {stop.stop_id: stop for stop in road_map.stops}
        self._port = port
        self._transport: asyncio.DatagramTransport | None = None

    def add(self, ticket: dict[str, Any], demand: RideDemand) -> None:
        self._send(
            RiderComes(
                ticket["ride_id"],
                ticket["boarding_code"],
                demand.party,
                demand.how,
                self._stop_pose(demand.from_stop),
                self._stop_pose(demand.to_stop),
            )
        )

    def assigned(self, ride_id: str, vehicle_id: str) -> None:
        self._send(RideAssigned(ride_id, vehicle_id))

    @contextlib.asynccontextmanager
    async def listening(self, tap: Tap) -> AsyncIterator[None]:
        """Forward the riders' taps while the context lasts."""
        taps: asyncio.Queue[RiderTapped] = asyncio.Queue()
        loop = asyncio.get_running_loop()
        transport, _ = await loop.create_datagram_endpoint(
            lambda: _TapReceiver(taps), remote_addr=(HOST, self._port)
        )
        self._transport = transport
        tasks = [asyncio.create_task(self._forward(taps, tap)), asyncio.create_task(self._subscribe())]
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            transport.close()

    async def _subscribe(self) -> None:
        """Repeated, because a restarted simulation has lost the subscription."""
        while True:
            self._send(Subscribe())
            await asyncio.sleep(SUBSCRIBE_EVERY_S)

    async def _forward(self, taps: "asyncio.Queue[RiderTapped]", tap: Tap) -> None:
        while True:
            tapped = await taps.get()
            await tap(tapped.ride_id, tapped.kind)

    def _send(self, message: ToSimulation) -> None:
        assert self._transport is not None, "listening() first"
        self._transport.sendto(encode(message))

    def _stop_pose(self, stop_id: str) -> Pose2:
        stop = self._stops[stop_id]
        return Pose2(*self._network.pose(stop.lane_id, stop.s_m))


class _TapReceiver(asyncio.DatagramProtocol):
    def __init__(self, taps: "asyncio.Queue[RiderTapped]") -> None:
        self._taps = taps

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:
        message = decode_from_simulation(data)
        if isinstance(message, RiderTapped):
            self._taps.put_nowait(message)
