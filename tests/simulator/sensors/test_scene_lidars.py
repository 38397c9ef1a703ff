"""Lidars of a world in its scene: timing, what moves, and what the driver makes of a turn."""

import math

import msgspec
import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.model import Building, RoadMap
from simulator.sensors.lidars.driver import moved_to_end
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import GroundParams
from simulator.sensors.scene_lidars import SceneOptions
from simulator.world import SimWorld, WorldError, WorldOptions
from tests.simulator.street import QuietPhone, street
from tests.simulator.traffic.careful_driver import START_NS
from vehicle_agent.config import LidarMount, PlanarScanner, Profile
from vehicle_agent.signals import ImuSample

STEP_NS = 20_000_000
PLAIN = SceneOptions(changes=WorldChanges(parked_ratio=0.0), ground=GroundParams(grade_ratio=0.0))
HOUSE = Building(((70.0, 6.0), (90.0, 6.0), (90.0, 16.0), (70.0, 16.0)), 9.0)


def a_world(
    poses: dict[str, Pose2],
    scene: SceneOptions = PLAIN,
    road_map: RoadMap | None = None,
    profile: Profile | None = None,
    speed_mps: float = 0.0,
) -> SimWorld:
    options = WorldOptions(traffic=None, scene=scene)
    profiles = dict.fromkeys(poses, profile or Profile())
    world = SimWorld(road_map or street(), profiles, poses, 1, QuietPhone(), options)
    for vehicle_id, pose in poses.items():
        world.place(vehicle_id, pose, speed_mps)
    return world


def scans(world: SimWorld, vehicle_id: str, steps: int, drives: bool = False) -> dict[int, np.ndarray]:
    """Points by step."""
    found = {}
    for k in range(steps):
        scan = world.scan(vehicle_id, START_NS + k * STEP_NS)
        if scan is not None:
            found[k] = scan[0]
        if drives:
            world.step(START_NS + k * STEP_NS)
    return found


def test_turns_end_every_100_ms_and_the_first_one_when_it_is_whole() -> None:
    world = a_world({"s1": Pose2(20.0, 0.0, 0.0), "s2": Pose2(60.0, 0.0, 0.0)})
    assert list(scans(world, "s1", 21)) == [5, 10, 15, 20]
    assert list(scans(world, "s2", 21)) == [6, 11, 16]


def test_another_shuttle_is_in_the_scan_and_its_own_is_not_doubled() -> None:
    world = a_world({"s1": Pose2(20.0, 0.0, 0.0), "s2": Pose2(32.0, 0.0, 0.0)})
    points = scans(world, "s1", 6)[5]
    ahead = points[(points[:, 0] > 4.5) & (np.abs(points[:, 1]) < 0.6) & (points[:, 2] > 0.4)]
    assert len(ahead) > 50
    assert ahead[:, 0].min() == pytest.approx(12.0 - 0.85, abs=0.15)


def test_points_of_a_vehicle_that_drives_fit_the_base_at_the_end_of_the_turn() -> None:
    world = a_world({"s1": Pose2(40.0, 0.0, 0.0)}, road_map=street((HOUSE,)), speed_mps=3.0)
    found = scans(world, "s1", 11, drives=True)
    points = found[10]
    # `scan` gives the world at its stamp; the step after it has moved the vehicle on.
    x_m = world.truth("s1").pose_map.x_m - 3.0 * 0.02
    west = points[(points[:, 2] > 0.2) & (points[:, 1] > 6.2) & (np.abs(points[:, 0] + x_m - 70.0) < 1.0)]
    assert len(west) > 20
    # Without the motion of the turn the wall would be up to 0.3 m away.
    assert west[:, 0].min() + x_m == pytest.approx(70.0, abs=0.1)


def test_same_seeds_give_the_same_scans_of_a_drive() -> None:
    runs = [
        scans(a_world({"s1": Pose2(40.0, 0.0, 0.0)}, SceneOptions(seed=seed), speed_mps=2.0), "s1", 11, True)
        for seed in (1, 1, 2)
    ]
    digests = [b"".join(points.tobytes() for points in run.values()) for run in runs]
    assert digests[0] == digests[1] != digests[2]


def test_driver_turns_points_about_the_arc_that_is_still_driven() -> None:
    speed, rate, period_ns = 4.0, 0.5, 100_000_000
    offsets = np.array([0, 40_000_000, 100_000_000])
    target = np.array([15.0, 4.0])
    seen = []
    for offset in offsets:
        yaw = rate * offset * 1e-9
        place = speed / rate * np.array([math.sin(yaw), 1.0 - math.cos(yaw)])
        dx, dy = target - place
        seen.append((math.cos(yaw) * dx + math.sin(yaw) * dy, -math.sin(yaw) * dx + math.cos(yaw) * dy, 1.0))
    moved = moved_to_end(np.array(seen, dtype=np.float32), offsets, period_ns, speed, rate)
    assert np.ptp(moved, axis=0).max() < 1e-3


def test_hill_slows_the_vehicle_and_shows_in_its_truth() -> None:
    hills = SceneOptions(ground=GroundParams(grade_ratio=0.04))
    world = a_world({"s1": Pose2(100.0, 0.0, 0.0)}, hills, speed_mps=3.0)
    grades = []
    for k in range(25):
        world.step(START_NS + k * STEP_NS)
        grades.append(world.truth("s1").grade_ratio)
    assert world.scene_lidars is not None
    ground = world.scene_lidars.scene.ground
    rise = ground.road_m(np.array([103.0, 100.0]), np.zeros(2))
    assert np.mean(grades) == pytest.approx((rise[0] - rise[1]) / 3.0, abs=0.01)


def test_vehicle_that_stands_on_a_hill_measures_its_slope() -> None:
    hills = SceneOptions(ground=GroundParams(grade_ratio=0.04))
    world = a_world({"s1": Pose2(100.0, 0.0, 0.0)}, hills)
    assert world.scene_lidars is not None
    x_m = np.arange(20.0, 560.0)
    heights_m = world.scene_lidars.scene.ground.road_m(x_m, np.zeros(len(x_m)))
    world.place("s1", Pose2(float(x_m[np.argmax(np.diff(heights_m))]), 0.0, 0.0))
    world.step(START_NS)
    truth = world.truth("s1")
    measured = []
    for k in range(400):
        items = world.sensor_items("s1", START_NS + k * STEP_NS)
        measured += [item.accel_mps2 for item in items if isinstance(item, ImuSample)]
    assert truth.grade_ratio > 0.02
    assert np.mean(measured) == pytest.approx(truth.accel_mps2 + 9.81 * truth.grade_ratio, abs=0.04)


def test_dead_sensor_gives_no_scan_until_it_works_again() -> None:
    world = a_world({"s1": Pose2(20.0, 0.0, 0.0)})
    assert world.scene_lidars is not None
    (sensor,) = world.scene_lidars.faults("s1")
    sensor.fault = "dead"
    assert scans(world, "s1", 8) == {}
    sensor.fault = None
    found = {k: world.scan("s1", START_NS + k * STEP_NS) for k in range(8, 16)}
    assert [k for k, scan in found.items() if scan is not None] == [10, 15]


def test_four_lidars_are_one_cloud() -> None:
    one = scans(a_world({"s1": Pose2(20.0, 0.0, 0.0)}), "s1", 6)[5]
    four = SceneOptions(changes=PLAIN.changes, ground=PLAIN.ground, four=True)
    assert len(scans(a_world({"s1": Pose2(20.0, 0.0, 0.0)}, four), "s1", 6)[5]) > 2 * len(one)


def test_vehicle_without_lidar_has_no_scan() -> None:
    blind = Profile(lidar=LidarMount(rate_hz=0.0))
    assert scans(a_world({"s1": Pose2(20.0, 0.0, 0.0)}, profile=blind), "s1", 8) == {}


def test_altered_buildings_are_what_the_world_scores_with() -> None:
    gone = SceneOptions(changes=WorldChanges(seed=1, buildings_altered_ratio=1.0))
    world = a_world({"s1": Pose2(20.0, 0.0, 0.0)}, gone, street((HOUSE,)))
    assert world.scene_lidars is not None
    assert world.scene_lidars.scene.buildings != (HOUSE,)


def test_map_without_lanes_is_refused_with_the_reason() -> None:
    bare = RoadMap("none", "None", street().origin, (), (), (), ())
    with pytest.raises(WorldError, match="lanes"):
        a_world({"s1": Pose2(20.0, 0.0, 0.0)}, road_map=bare)


SCANNING = Profile(planar_scanner=PlanarScanner(x_m=3.0, z_m=2.4, rate_hz=10.0))


def planar_scans(world: SimWorld, steps: int) -> dict[int, np.ndarray]:
    """Points by step, of a vehicle that drives on."""
    found = {}
    for k in range(steps):
        scan = world.planar_scan("a", START_NS + k * STEP_NS)
        if scan is not None:
            found[k] = scan[0]
        world.step(START_NS + k * STEP_NS)
    return found


def test_planar_scanner_sees_a_wall_ten_times_a_second_from_where_the_vehicle_is() -> None:
    road_map = msgspec.structs.replace(street(), buildings=(HOUSE,))
    pose = Pose2(60.0, 0.0, 0.0)
    world = a_world({"a": pose}, road_map=road_map, profile=SCANNING)
    found = planar_scans(world, 12)
    assert len(found) == 3
    assert np.diff(list(found)) == pytest.approx(5)
    points = list(found.values())[-1]
    # The house's front is 6 m to the left, from 70 m on; the columns of its facade stand in front of it.
    wall = points[(points[:, 0] > 12.0) & (points[:, 0] < 28.0) & (points[:, 1] > 5.0) & (points[:, 1] < 7.5)]
    assert len(wall) > 10
    assert np.abs(points[:, 2] - 2.4).max() < 1e-3


def test_dead_planar_scanner_says_nothing_and_a_vehicle_without_one_has_none() -> None:
    world = a_world({"a": Pose2(60.0, 0.0, 0.0)}, profile=SCANNING)
    assert world.scene_lidars is not None
    world.scene_lidars.planar_scanner("a").fault = "dead"
    assert planar_scans(world, 12) == {}
    assert planar_scans(a_world({"a": Pose2(60.0, 0.0, 0.0)}), 12) == {}
