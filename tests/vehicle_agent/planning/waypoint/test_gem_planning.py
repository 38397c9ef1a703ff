"""The planning room: who limits the speed, and when it goes on."""

import math

import msgspec
import numpy as np

from tests.vehicle_agent.planning.builders import ROOM, TICK_NS, a_task, a_world, an_ego
from vehicle_agent.planning.waypoint.waypoint_planning import WaypointPlanningState
from vehicle_agent.signals import Path, Task, World


def planned(
    state: WaypointPlanningState, tick: int, world: World, task: Task, speed_mps: float = 3.0
) -> tuple[Path, WaypointPlanningState]:
    return ROOM.step(state, an_ego(tick * TICK_NS, speed_mps=speed_mps), world, task)


def first(world: World, task: Task, speed_mps: float = 3.0) -> Path:
    return planned(ROOM.initial(), 1, world, task, speed_mps)[0]


def test_a_free_road_is_driven_at_the_waypoints_speed() -> None:
    path = first(a_world(), a_task())
    assert (path.limited_by, path.speed_mps, path.obstacle_m, path.emergency) == (
        "waypoint_speed",
        3.0,
        None,
        False,
    )
    np.testing.assert_allclose(path.points_map[0], [21.0, 0.0], atol=1e-8)


def test_without_a_line_the_vehicle_stands() -> None:
    task = msgspec.structs.replace(a_task(), line=None, line_id=0)
    path = first(a_world(), task)
    assert (path.speed_mps, path.limited_by, len(path.points_map)) == (0.0, "no_order", 0)


def test_an_obstacle_limits_by_its_distance() -> None:
    path = first(a_world((20.0 + 3.5 + 12.5, 0.0)), a_task())
    assert path.limited_by == "obstacle"
    assert abs(path.speed_mps - 1.5) < 1e-9


def test_somebody_who_steps_in_close_is_an_emergency() -> None:
    path = first(a_world((20.0 + 3.5 + 3.0, 0.0)), a_task())
    assert path.emergency
    assert path.speed_mps == 0.0


def test_people_are_not_crept_at_and_the_path_must_stay_clear_before_going_on() -> None:
    person = (20.0 + 3.5 + 6.2, 0.0)
    path, state = planned(ROOM.initial(), 1, a_world(person), a_task(), 0.0)
    assert path.speed_mps == 0.0
    speeds = []
    for look in range(2, 2 + ROOM.patience.clear_looks + 2):
        path, state = planned(state, 5 * look, a_world(seen_ns=look), a_task(), 0.0)
        speeds.append(path.speed_mps)
    assert speeds[: ROOM.patience.clear_looks - 1] == [0.0] * (ROOM.patience.clear_looks - 1)
    assert speeds[-1] > 0.0


def test_a_flicker_of_free_road_does_not_start_the_vehicle() -> None:
    person = (20.0 + 3.5 + 6.0, 0.0)
    _, state = planned(ROOM.initial(), 1, a_world(person), a_task(), 0.0)
    for look in range(2, 40):
        points = (person,) if look % 4 == 0 else ()
        path, state = planned(state, 5 * look, a_world(*points, seen_ns=look), a_task(), 0.0)
        assert path.speed_mps == 0.0


def test_something_just_beside_the_path_is_passed_slowly() -> None:
    path = first(a_world((20.0 + 3.5 + 4.0, 1.5)), a_task())
    assert (path.limited_by, path.speed_mps) == ("passing", ROOM.obstacle.passing_mps)


def test_the_obstacle_comes_nearer_between_two_looks() -> None:
    path, state = planned(ROOM.initial(), 1, a_world((20.0 + 3.5 + 12.5, 0.0)), a_task())
    after, _ = planned(state, 2, a_world((20.0 + 3.5 + 12.5, 0.0)), a_task(20.06))
    assert path.obstacle_m is not None
    assert after.obstacle_m is not None
    assert abs(path.obstacle_m - after.obstacle_m - 0.06) < 1e-9


def test_a_missing_grant_is_named() -> None:
    path = first(a_world(), a_task(stop_s_m=24.0, waiting="east/1"))
    assert path.limited_by == "section"


def test_a_poor_position_means_half_a_metre_a_second_and_none_means_standing() -> None:
    for std_m in (0.5, math.nan):
        poor = ROOM.step(ROOM.initial(), an_ego(TICK_NS, std_m=std_m), a_world(), a_task())[0]
        assert (poor.limited_by, poor.speed_mps) == ("poor_position", 0.5)
    lost = msgspec.structs.replace(an_ego(TICK_NS), valid=False)
    assert ROOM.step(ROOM.initial(), lost, a_world(), a_task())[0].speed_mps == 0.0


def test_a_blind_vehicle_stands() -> None:
    blind = msgspec.structs.replace(a_world(), blind=True)
    assert first(blind, a_task()).limited_by == "blind"


def test_dwelling_and_idling_stand() -> None:
    assert first(a_world(), a_task(stop_s_m=20.0, mode="dwell"), 0.0).speed_mps == 0.0
    assert first(a_world(), a_task(stop_s_m=20.0, mode="idle"), 0.0).speed_mps == 0.0
