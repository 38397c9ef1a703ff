"""What every fault finds: a served campus, two shuttles on the link, and riders who book."""

import asyncio
import random
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from benchmarks.bookings.nats import Nats
from benchmarks.bookings.postgresql import PostgreSql
from benchmarks.faults.agent_process import AgentProcess
from benchmarks.faults.installation import MAP, Installation
from benchmarks.faults.riders import Riders
from benchmarks.faults.stored_events import acknowledged_by, not_stored
from benchmarks.faults.wire_vehicle import WireVehicle
from campusloop.simulation.history.records import Violation
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from contract.wire.messages import DoorsChanged, VehicleEvent


class FaultNotHandled(AssertionError):
    """The server did something else than it must do under this fault; the text says what."""


@dataclass
class Stage:
    """first, second: shuttles that serve riders; agents: link processes that a fault has started."""

    installation: Installation
    network: RoadNetwork
    riders: Riders
    first: WireVehicle
    second: WireVehicle
    rng: random.Random
    postgresql_server: PostgreSql | None = None
    nats_server: Nats | None = None
    agents: list[AgentProcess] = field(default_factory=list)
    tasks: list["asyncio.Task[None]"] = field(default_factory=list)

    @property
    def postgresql(self) -> PostgreSql:
        assert self.postgresql_server is not None, "the fault is one of PostgreSQL"
        return self.postgresql_server

    @property
    def broker(self) -> Nats:
        assert self.nats_server is not None, "the fault needs a broker"
        return self.nats_server

    def an_event(self, number: int = 0) -> VehicleEvent:
        return DoorsChanged(number % 2 == 1, f"visit-{number}")

    def lost_events(self) -> list[Violation]:
        """Acknowledged ones, and those on the disk of an agent, that the server does not have."""
        promised = acknowledged_by(self.first) | acknowledged_by(self.second)
        for agent in self.agents:
            promised |= agent.promised()
        return not_stored(self.installation.url, promised)

    async def until_stored(self, agent: AgentProcess) -> None:
        """Until the server has what the agent has on its disk now."""
        promised = agent.promised()
        require(any(promised.values()), "the agent has reported nothing")

        async def is_stored() -> bool:
            return not not_stored(self.installation.url, promised)

        await self.until(is_stored, "the events of the agent are stored", 60.0)

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
async def a_stage(
    installation: Installation, seed: int, postgresql: PostgreSql | None = None, nats: Nats | None = None
) -> AsyncIterator[Stage]:
    network = RoadNetwork(load_map(MAP))
    stops = [stop.stop_id for stop in network.road_map.stops]
    riders = Riders(installation.origin, stops, seed)
    first, second = (WireVehicle(installation, network, f"shuttle-{n + 1}", n) for n in range(2))
    stage = Stage(installation, network, riders, first, second, random.Random(seed), postgresql, nats)
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
