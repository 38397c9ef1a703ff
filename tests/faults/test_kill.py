"""SIGKILL on real processes in the middle of a ride: it completes, once, when an operator says so."""

import asyncio
import math
from pathlib import Path

import pytest

from tests.contract.roads.ring_map import SIDE_M
from tests.faults.real_campus import RealCampus, a_real_campus
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car

pytestmark = pytest.mark.faults


async def speed_mps(real: RealCampus) -> float:
    status = (await real.campus.operator.vehicle("shuttle-1"))["status"]
    return abs(float(status["speed_mps"]))


async def place_map(real: RealCampus) -> tuple[float, float]:
    pose_map = (await real.campus.operator.vehicle("shuttle-1"))["status"]["pose_map"]
    return pose_map["x_m"], pose_map["y_m"]


async def mode(real: RealCampus) -> str:
    return str((await real.shuttle())["mode"])


async def is_on_a_straight(real: RealCampus, ahead_m: float) -> bool:
    status = (await real.campus.operator.vehicle("shuttle-1"))["status"]
    return str(status["lane_id"]).startswith("side") and float(status["s_m"]) < SIDE_M - ahead_m


async def drives(real: RealCampus, *, straight_m: float = 0.0) -> None:
    """Wait until the server hears that the shuttle gets on; the operator resumes it where that is needed.

    straight_m  not before this much of a straight lies ahead. A shuttle that coasts into a bend until its
                gate is back leaves the road, and would have to be driven back by hand

    The newest status may be older than the link that was just killed, so its speed alone tells nothing. Nor
    does a motion without the mode: a shuttle coasts, too.
    """
    began_map = await place_map(real)
    for _ in range(120):
        moves = math.dist(await place_map(real), began_map) > 1.0 and await speed_mps(real) > 1.0
        moves = moves and await mode(real) == "autonomous"
        if moves and (not straight_m or await is_on_a_straight(real, straight_m)):
            return
        await real.keep_going()
        await asyncio.sleep(0.5)
    raise AssertionError(f"the shuttle does not drive: {real.states} {await real.shuttle()}")


async def notices(real: RealCampus) -> None:
    """The shuttle tells that it no longer drives by itself, before it is resumed."""
    for _ in range(60):
        if await mode(real) != "autonomous":
            return
        await asyncio.sleep(0.2)
    raise AssertionError(f"the shuttle has not noticed: {await real.shuttle()}")


async def stands_held(real: RealCampus) -> None:
    for _ in range(60):
        if (await real.campus.operator.vehicle("shuttle-1"))["held"] and await speed_mps(real) < 0.05:
            return
        await asyncio.sleep(0.5)
    raise AssertionError("the shuttle neither stands nor is it held")


def test_a_ride_outlives_the_kill_of_every_process_in_turn(tmp_path: Path) -> None:
    """Link and gate are begun anew, and ride and recording go on; a tick stands held until it is resumed."""

    async def scenario() -> None:
        async with a_real_campus(tmp_path, 48_100) as real:
            # Two sides of the ring: on the one in the middle the gate is killed.
            journey = real.request_ride(("stop-0", "stop-2"))
            await real.until_state(journey, "aboard")
            await drives(real)
            pid = real.kill("link")
            await real.until_restarted("link", pid)
            # It coasts for some 30 m from its speed when nothing brakes.
            await drives(real, straight_m=50.0)
            pid = real.kill("gate shuttle-1")
            await real.until_restarted("gate shuttle-1", pid)
            await notices(real)
            await drives(real, straight_m=15.0)
            pid = real.kill("tick shuttle-1")
            await real.until_restarted("tick shuttle-1", pid)
            await stands_held(real)
            assert journey.state == "aboard"
            await real.campus.operator.release("shuttle-1")
            await drives(real)
            pid = real.kill("server")
            await real.until_restarted("server", pid)
            await real.until_state(journey, "completed")
            assert [state for _, state in journey.history].count("completed") == 1
            rides = (await real.campus.client.get("/api/v1/rides")).json()
            assert [ride["state"] for ride in rides if ride["state"] != "refused"] == ["completed"]
        segments = sorted((tmp_path / "campus" / "vehicles").rglob("*.mcap"))
        boots = sorted({segment.parent for segment in segments})
        assert len(boots) == 2
        before_and_after_the_link_was_killed = sorted(boots[0].glob("*.mcap"))
        assert len(before_and_after_the_link_was_killed) == 2
        for segment in segments:
            assert replay_segment(segment, build_car).difference is None

    asyncio.run(scenario())
