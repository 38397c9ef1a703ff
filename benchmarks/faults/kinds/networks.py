"""Networks and proxies between vehicles and the server."""

import asyncio
from collections.abc import Awaitable, Callable

from benchmarks.faults.agent_process import an_agent
from benchmarks.faults.relay import a_relay
from benchmarks.faults.stage import Stage, require

_REFUSES_S = 6.0
_FROZEN_S = 5.0
_BACKLOG = 20_000
_BACKLOG_WITHIN_S = 90.0


async def connection_forgotten_by_nat(stage: Stage) -> None:
    """The vehicle's connection leads nowhere and is open on both sides; it dials again past the NAT."""
    vehicle = stage.first
    async with a_relay(stage.installation.port) as relay:
        vehicle.port = relay.port
        await vehicle.redial()
        require(relay.connections > 0, "the vehicle does not go through the relay")
        relay.is_frozen = True
        await asyncio.sleep(_FROZEN_S)
        vehicle.port = None
        await vehicle.redial()
        before = vehicle.acknowledged
        vehicle.report(stage.an_event())
        await stage.until(_acknowledged(stage, before + 1), "an event over the new connection")
    require("key_conflict" not in await stage.open_incidents(), "one vehicle counts as two agents")


async def proxy_without_a_server(stage: Stage) -> None:
    """The proxy answers 502 for 6 s, to the agent's own link, which must come back by itself."""
    async with a_relay(stage.installation.port) as relay:
        relay.refuses = True
        async with an_agent(stage.installation, "shuttle-3", 2, relay.port) as agent:
            stage.agents.append(agent)
            await asyncio.sleep(_REFUSES_S)
            require(relay.refused > 0, "the link has not dialled")
            relay.refuses = False
            await stage.until_stored(agent)


async def frames_byte_by_byte(stage: Stage) -> None:
    """Every byte of a vehicle comes in a packet of its own."""
    async with a_relay(stage.installation.port) as relay:
        relay.drips = True
        stage.first.port = relay.port
        await stage.first.redial()
        for number in range(5):
            stage.first.report(stage.an_event(number))
        await stage.until(_acknowledged(stage, len(stage.first.events)), "events byte by byte", 40.0)
        stage.first.port = None
        await stage.first.redial()


async def backlog_of_a_day(stage: Stage) -> None:
    """A vehicle that was offline for a day reports 20,000 events at once."""
    for number in range(_BACKLOG):
        stage.first.report(stage.an_event(number))
    await stage.until(_acknowledged(stage, len(stage.first.events)), "the events of a day", _BACKLOG_WITHIN_S)
    slowest_s = max(stage.riders.answers_s)
    require(slowest_s < 15.0, f"a booking took {slowest_s:.1f} s meanwhile")


def _acknowledged(stage: Stage, count: int) -> Callable[[], Awaitable[bool]]:
    async def is_reached() -> bool:
        return stage.first.acknowledged >= count

    return is_reached
