"""SIGKILL on real processes in the middle of a ride: it completes, once, when an operator says so."""

import asyncio
from pathlib import Path

import pytest

from tests.faults.real_campus import RealCampus, a_real_campus
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.gem import gem

pytestmark = pytest.mark.faults


async def speed_mps(real: RealCampus) -> float:
    live = (await real.campus.operator.vehicle("shuttle-1"))["live"]
    return abs(float(live["speed_mps"]))


async def ride_on(real: RealCampus) -> None:
    """Wait until the shuttle is really under way."""
    for _ in range(200):
        if await speed_mps(real) > 1.0:
            return
        await asyncio.sleep(0.2)
    raise AssertionError("the shuttle does not move")


def test_a_tick_process_killed_while_riding_is_braked_for_and_rides_on_after_resume(tmp_path: Path) -> None:
    async def scenario() -> None:
        async with a_real_campus(tmp_path, 48_100) as real:
            journey = real.ask()
            await real.until_state(journey, "aboard")
            await ride_on(real)
            pid = real.kill("tick shuttle-1")
            await real.until_restarted("tick shuttle-1", pid)
            await asyncio.sleep(4.0)
            vehicle = await real.campus.operator.vehicle("shuttle-1")
            assert vehicle["held"]
            assert await speed_mps(real) < 0.05
            assert journey.state == "aboard"
            await real.campus.operator.release("shuttle-1")
            await real.until_state(journey, "completed")
            assert [state for _, state in journey.history].count("completed") == 1
        segments = sorted((tmp_path / "campus" / "vehicles").rglob("*.mcap"))
        assert len({segment.parent for segment in segments}) == 2
        for segment in segments:
            assert replay_segment(segment, gem).difference is None

    asyncio.run(scenario())


def test_a_server_killed_while_riding_finds_ride_and_vehicle_again(tmp_path: Path) -> None:
    async def scenario() -> None:
        async with a_real_campus(tmp_path, 49_100) as real:
            journey = real.ask()
            await real.until_state(journey, "aboard")
            await ride_on(real)
            pid = real.kill("server")
            await real.until_restarted("server", pid)
            await real.until_state(journey, "completed")
            assert [state for _, state in journey.history].count("completed") == 1
            rides = (await real.campus.client.get("/api/v1/rides")).json()
            assert [ride["state"] for ride in rides] == ["completed"]

    asyncio.run(scenario())


def test_link_and_gate_killed_while_riding_lose_nothing(tmp_path: Path) -> None:
    async def scenario() -> None:
        async with a_real_campus(tmp_path, 50_100) as real:
            journey = real.ask()
            await real.until_state(journey, "aboard")
            await ride_on(real)
            for name in ("link", "gate shuttle-1"):
                pid = real.kill(name)
                await real.until_restarted(name, pid)
            await asyncio.sleep(3.0)
            if (await real.campus.operator.vehicle("shuttle-1"))["held"]:
                await real.campus.operator.release("shuttle-1")
            await real.until_state(journey, "completed")

    asyncio.run(scenario())
