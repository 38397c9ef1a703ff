"""Every stack docks within 20 cm of the stop, by the simulation's truth."""

import math
from functools import partial
from pathlib import Path

import msgspec
import pytest

from simulator.world import WorldOptions
from tests.vehicle_agent.driven_shuttle import DrivenShuttle
from tests.vehicle_agent.mission.ring import ring
from vehicle_agent.config import LidarMount, load_profile

PROFILES = Path(__file__).resolve().parents[3] / "vehicle_agent" / "profiles"
RING = ring()
START, REST = ("south", 72.0), ("north", 70.0)
# Just behind a bend, and on a straight.
STOPS = (("north", 3.0), ("north", 22.0))
DOCKED_M = 0.2


def place(shuttle: DrivenShuttle) -> tuple[float, float]:
    pose = shuttle.world.truth("s1").pose_map
    return pose.x_m, pose.y_m


def comes_to(shuttle: DrivenShuttle, stop: tuple[str, float]) -> bool:
    """Within 3 m of the stop, and at rest by the truth."""
    is_near = math.dist(place(shuttle), shuttle.network.pose(*stop)[:2]) < 3.0
    return is_near and shuttle.world.truth("s1").speed_mps < 0.005


@pytest.mark.parametrize("name", ["gem-e2", "nus-cart", "snow-lion"])
def test_the_vehicle_docks_within_20_cm_of_each_stop(name: str) -> None:
    profile = msgspec.structs.replace(load_profile(PROFILES / f"{name}.toml"), lidar=LidarMount(rate_hz=0.0))
    shuttle = DrivenShuttle(RING, START, profile, WorldOptions(traffic=None, lidar=False))
    visits = [
        shuttle.visit(f"stop-{i}", *stop, before, dwell_s=1.0)
        for i, (stop, before) in enumerate(zip(STOPS, (START, *STOPS[:-1]), strict=True))
    ]
    rest = shuttle.visit("rest", *REST, STOPS[-1], kind="rest", dwell_s=0.0)
    shuttle.say(shuttle.order_for((*visits, rest), START))
    shuttle.run(1.0)
    shuttle.resume()
    for stop in STOPS:
        assert shuttle.run(90.0, partial(comes_to, stop=stop)), stop
        # Where it first comes to rest, and not only after it has crept on.
        assert math.dist(place(shuttle), shuttle.network.pose(*stop)[:2]) <= DOCKED_M, (stop, place(shuttle))
        assert shuttle.run(10.0, lambda s: s.state.mission.doors.phase == "open"), stop
        x_m, y_m, yaw_rad = shuttle.network.pose(*stop)
        pose = shuttle.world.truth("s1").pose_map
        assert math.hypot(pose.x_m - x_m, pose.y_m - y_m) <= DOCKED_M, (stop, pose)
        assert abs(math.remainder(pose.yaw_rad - yaw_rad, math.tau)) < math.radians(5.0), (stop, pose)
        assert shuttle.run(20.0, lambda s: s.state.mission.doors.phase == "closed"), stop
