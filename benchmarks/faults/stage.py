"""What every fault finds: a served campus, two shuttles on the link, and riders who book."""

import asyncio
import random
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from benchmarks.faults.installation import MAP, Installation
from benchmarks.faults.riders import Riders
from benchmarks.faults.wire_vehicle import WireVehicle
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork


class FaultNotHandled(AssertionError):
    """The server did something else than it must do under this fault; the text says what."""


@dataclass
class Stage:
    """first, second: shuttles that serve riders."""

    installation: Installation
    network: RoadNetwork
    riders: Riders
    first: WireVehicle
    second: WireVehicle
    rng: random.Random
    tasks: list["asyncio.Task[None]"] = field(default_factory=list)

    def start(self, vehicle: WireVehicle) -> None:
        self.tasks.append(asyncio.create_task(vehicle.run()))

    async def open_incidents(self) -> list[str]:
        return [incident["kind"] for incident in await self.installation.ask("GET", "/incidents")]

    async def until(
        self, condition: Callable[[], Awaitable[bool]], what: str, within_s: float = 20.0
    ) -> None:
        """Raises FaultNotHandled."""
        until_s = time.monotonic() + within_s
        while not await condition():
            require(time.monotonic() < until_s, f"{what}: not within {within_s:.0f} s")
            await asyncio.sleep(0.2)

    async def until_incident(self, kind: str) -> None:
        async def is_open() -> bool:
            return kind in await self.open_incidents()

        await self.until(is_open, f"incident {kind}")


def require(condition: bool, what: str) -> None:
    """Raises FaultNotHandled."""
    if not condition:
        raise FaultNotHandled(what)


@asynccontextmanager
async def a_stage(installation: Installation, seed: int) -> AsyncIterator[Stage]:
    network = RoadNetwork(load_map(MAP))
    stops = [stop.stop_id for stop in network.road_map.stops]
    riders = Riders(installation.origin, stops, seed)
    first, second = (WireVehicle(installation, network, f"shuttle-{n + 1}", n) for n in range(2))
    stage = Stage(installation, network, riders, first, second, random.Random(seed))
    try:
        for shuttle in (first, second):
            await shuttle.enrol()
            stage.start(shuttle)
        for shuttle in (first, second):
            await shuttle.until_served()
        stage.tasks.append(asyncio.create_task(riders.run()))
        yield stage
    finally:
        for task in stage.tasks:
            task.cancel()
        await asyncio.gather(*stage.tasks, return_exceptions=True)
