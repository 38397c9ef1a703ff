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


async def is_on_a_straight(real: RealCampus) -> bool:
    status = (await real.campus.operator.vehicle("shuttle-1"))["status"]
    return str(status["lane_id"]).startswith("side") and float(status["s_m"]) < SIDE_M - 15.0


async def drives(real: RealCampus, *, anywhere: bool = True) -> None:
    """Wait until the server hears that the shuttle gets on; the operator resumes it where that is needed.

    anywhere  also in a bend, where a shuttle that coasts until its gate is back may leave the road: it would
              have to be driven back by hand

    The newest status may be older than the link that was just killed, so its speed alone tells nothing.
    """
    began_map = await place_map(real)
    for _ in range(120):
        moves = math.dist(await place_map(real), began_map) > 1.0 and await speed_mps(real) > 1.0
        if moves and (anywhere or await is_on_a_straight(real)):
            return
        await real.keep_going()
        await asyncio.sleep(0.5)
    raise AssertionError(f"the shuttle does not move: {real.states}")


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
            journey = real.request_ride()
            await real.until_state(journey, "aboard")
            for name in ("link", "gate shuttle-1"):
                await drives(real, anywhere=name == "link")
                pid = real.kill(name)
                await real.until_restarted(name, pid)
            await drives(real, anywhere=False)
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
