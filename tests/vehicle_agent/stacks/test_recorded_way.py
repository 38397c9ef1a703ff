"""The GEM stack drives a recorded waypoint file on an order, and refuses files that it cannot drive."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from contract.geometry import Array
from contract.roads.model import Origin
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_line
from contract.wire.messages import VisitChanged
from simulator.world import WorldOptions
from tests.vehicle_agent.driven_shuttle import DrivenShuttle
from tests.vehicle_agent.mission.ring import ring
from vehicle_agent.config import Driving, LidarMount, Limits, Profile, ProfileError
from vehicle_agent.planning.waypoint.recorded import RecordedWay, waypoints_on_line
from vehicle_agent.planning.waypoint.waypoints import WaypointRules
from vehicle_agent.stacks.choice import build_car
from vehicle_agent.waypoints.files import file_name, write_recording
from vehicle_agent.waypoints.recorder import Waypoint

RING = ring()
START, STOP, END = ("south", 5.0), ("south", 60.0), ("north", 70.0)
LEFT_M = 0.5


def driven_by_hand() -> Array:
    """(n, 2): once from the start to the resting place, half a metre left of the lane's middle."""
    network = RoadNetwork(RING)
    route = find_route(network, *START, *END)
    assert route is not None
    points = route_line(network, route).points
    steps = np.gradient(points, axis=0)
    steps /= np.hypot(*steps.T)[:, None]
    return np.asarray(points + LEFT_M * np.column_stack((-steps[:, 1], steps[:, 0])))


def recorded(folder: Path, points: Array, origin: Origin = RING.origin) -> Profile:
    """A profile that names files of 1.5 and 2 m/s of these points."""
    waypoints = [Waypoint(float(x), float(y), 2.0, 40.0) for x, y in points]
    write_recording(folder, "tour", waypoints, origin, [1.5, 2.0])
    return a_profile(folder)


def a_profile(folder: Path, speed_mps: float = 2.0) -> Profile:
    return Profile(
        limits=Limits(speed_mps_max=speed_mps),
        lidar=LidarMount(rate_hz=0.0),
        driving=Driving(waypoint_files=str(folder / "tour")),
    )


def driving(profile: Profile) -> DrivenShuttle:
    shuttle = DrivenShuttle(RING, START, profile, WorldOptions(traffic=None, lidar=False))
    stop = shuttle.visit("stop", *STOP, START, dwell_s=3.0)
    rest = shuttle.visit("rest", *END, STOP, kind="rest", dwell_s=0.0)
    shuttle.say(shuttle.order_for((stop, rest), START))
    shuttle.run(1.0)
    shuttle.resume()
    return shuttle


@pytest.mark.parametrize("speed_mps", [1.5, 2.0])
def test_an_order_is_driven_on_the_recorded_way_at_the_file_s_speed(tmp_path: Path, speed_mps: float) -> None:
    recorded(tmp_path, driven_by_hand())
    shuttle = driving(a_profile(tmp_path, speed_mps))
    places: list[tuple[float, float, float]] = []

    def is_at_the_stop(driven: DrivenShuttle) -> bool:
        truth = driven.world.truth("s1")
        places.append((truth.pose_map.x_m, truth.pose_map.y_m, truth.speed_mps))
        return driven.state.mission.doors.phase == "open"

    assert shuttle.run(80.0, is_at_the_stop)
    way = np.array(places)
    cruising = (way[:, 0] > 25.0) & (way[:, 0] < 50.0)
    beside = way[cruising, 1]
    assert beside == pytest.approx(np.full(len(beside), LEFT_M), abs=0.15), (
        "on the recording, not on the lane"
    )
    assert np.median(way[cruising, 2]) == pytest.approx(speed_mps, abs=0.1)
    assert abs(way[-1, 0] - STOP[1]) < 0.2
    assert any(isinstance(event, VisitChanged) for _, event in shuttle.events)


def test_on_an_order_that_the_recording_does_not_cover_the_vehicle_stands_and_says_so(tmp_path: Path) -> None:
    points = driven_by_hand()
    shuttle = driving(recorded(tmp_path, points[:30]))
    shuttle.run(5.0)
    assert shuttle.outputs is not None
    assert shuttle.outputs.flow.path.limited_by == "no_plan"
    assert shuttle.world.truth("s1").odometer_m < 0.01


def test_the_waypoints_end_with_speed_zero_where_the_recording_ends() -> None:
    points, network = driven_by_hand(), RoadNetwork(RING)
    route = find_route(network, *START, *END)
    assert route is not None
    line = route_line(network, route)
    way = RecordedWay(points[:40], np.full(40, 2.0))
    waypoints, covered_m = waypoints_on_line(way, line, 0.0, WaypointRules(2.0))
    assert covered_m == pytest.approx(41.0, abs=1.0), "half a gap beyond the last waypoint"
    assert waypoints.speeds_mps[waypoints.s_m > covered_m] == pytest.approx(0.0)
    slopes = np.diff(np.square(waypoints.speeds_mps)) / (2.0 * np.diff(waypoints.s_m))
    assert slopes.min() >= -WaypointRules().decel_mps2 - 1e-9
    none, covered_m = waypoints_on_line(
        RecordedWay(points[20:40], way.speeds_mps[20:]), line, 0.0, WaypointRules()
    )
    assert covered_m == 0.0
    assert none.speeds_mps == pytest.approx(0.0)


def test_a_file_with_a_hole_is_refused_with_its_place(tmp_path: Path) -> None:
    points = driven_by_hand()
    profile = recorded(tmp_path, np.vstack((points[:20], points[40:])))
    with pytest.raises(ProfileError, match=r"tour-2\.0mps\.csv: a hole of .* after waypoint 20"):
        build_car(profile, RING)


def test_a_file_of_another_campus_is_refused_by_name(tmp_path: Path) -> None:
    profile = recorded(tmp_path, driven_by_hand(), Origin(30.6, -96.3))
    with pytest.raises(ProfileError, match=r"another campus.*ring"):
        build_car(profile, RING)


def test_a_file_that_leaves_the_roads_is_refused_with_the_waypoint(tmp_path: Path) -> None:
    points = driven_by_hand()
    points[50:54, 1] -= 3.0
    with pytest.raises(ProfileError, match=r"waypoint 51 is .* from every lane"):
        build_car(recorded(tmp_path, points), RING)


def test_a_speed_without_a_file_is_refused_with_the_files_that_there_are(tmp_path: Path) -> None:
    recorded(tmp_path, driven_by_hand())
    with pytest.raises(ProfileError, match=file_name("tour", 1.5).replace(".", r"\.")):
        build_car(a_profile(tmp_path, 3.0), RING)


def test_a_stack_that_drives_no_waypoint_files_refuses_them(tmp_path: Path) -> None:
    profile = msgspec.structs.replace(recorded(tmp_path, driven_by_hand()), stack="snow_lion")
    with pytest.raises(ProfileError, match="only the gem stack"):
        build_car(profile, RING)
