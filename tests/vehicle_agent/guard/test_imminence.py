"""Who is braked for, and who is not: people, cyclists and vehicles around a shuttle at 15 km/h and slower."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2
from vehicle_agent.config import Profile
from vehicle_agent.gate.footprint import is_met_on_arc
from vehicle_agent.gate.settings import gate_settings
from vehicle_agent.guard.imminence import clearance_m, travel_m, will_touch
from vehicle_agent.signals import (
    CYCLIST,
    NO_TRACKS,
    PEDESTRIAN,
    VEHICLE,
    Ego,
    FleetVehicle,
    Tracks,
    VehicleMotion,
    World,
)
from vehicle_agent.stacks.rooms import guard

AVOIDANCE = guard(Profile()).avoidance
BODY = Profile().body
FRONT, HALF = BODY.front_overhang_m, 0.5 * BODY.width_m
NOW_NS = 5_000_000_000


def a_track(
    x: float, y: float, vx: float = 0.0, vy: float = 0.0, kind: int = PEDESTRIAN, yaw: float = 0.0
) -> Tracks:
    size = {PEDESTRIAN: (0.5, 0.5), CYCLIST: (1.8, 0.6), VEHICLE: (4.35, 1.63)}[kind]
    return Tracks(
        NOW_NS,
        np.array([1]),
        np.array([kind]),
        np.array([[x, y, yaw]]),
        np.array([[vx, vy]]),
        np.array([size]),
    )


def brake(
    tracks: Tracks = NO_TRACKS,
    speed: float = 15.0 / 3.6,
    steer: float = 0.0,
    actual: float | None = None,
    points: tuple[tuple[float, float], ...] = (),
    others: tuple[FleetVehicle, ...] = (),
    braking: bool = False,
    pose: Pose2 | None = None,
) -> float:
    pose = pose or Pose2(0.0, 0.0, 0.0)
    ego = Ego(NOW_NS, pose, speed, 0.0, 0.0, 0.0, 0.02, NOW_NS, True)
    motion = VehicleMotion(
        NOW_NS, speed, steer if actual is None else actual, 0.0, 0.0, True, False, True, 0.9
    )
    world = World(NOW_NS, NOW_NS, np.array(points).reshape(-1, 2), others, (), False, tracks)
    _, rows = AVOIDANCE.road_users(world, ego)
    return AVOIDANCE.brake_ratio(rows, ego, motion, steer, speed, braking)


def stopping_m(speed: float) -> float:
    return speed * AVOIDANCE.response_s + speed**2 / (2.0 * AVOIDANCE.brake_mps2)


@pytest.mark.parametrize("speed", [1.0, 2.0, 3.0, 15.0 / 3.6])
def test_braking_for_a_standing_person_begins_at_the_stopping_distance(
    speed: float,
) -> None:
    near = FRONT + 0.25 + stopping_m(speed)
    assert brake(a_track(near + 0.25, 0.0), speed) > 0.0
    assert brake(a_track(near + 1.2, 0.0), speed) == 0.0


def test_a_person_who_steps_out_close_ahead_causes_full_braking() -> None:
    assert brake(a_track(FRONT + 0.25 + 0.8, -1.2, 0.0, 1.5), 3.0) == 1.0


def test_slow_speeds_need_little_braking() -> None:
    pedals = [
        brake(a_track(FRONT + 0.25 + stopping_m(speed) + 0.29, 0.0), speed) for speed in (0.8, 15.0 / 3.6)
    ]
    assert 0.0 < pedals[0] < pedals[1] <= 1.0


@pytest.mark.parametrize("aside", [0.45, 0.6, 1.0])
@pytest.mark.parametrize("x", [-1.0, 1.0, 3.0, 4.5, 6.0])
@pytest.mark.parametrize("vx", [-1.4, 0.0, 1.4])
def test_walking_alongside_the_vehicle_is_no_danger(aside: float, x: float, vx: float) -> None:
    for side in (1.0, -1.0):
        assert brake(a_track(x, side * (HALF + 0.25 + aside), vx), 15.0 / 3.6) == 0.0


@pytest.mark.parametrize("aside", [0.15, 0.3])
def test_at_walking_pace_people_may_be_close(aside: float) -> None:
    assert brake(a_track(2.0, HALF + 0.25 + aside, 1.2), 1.2) == 0.0


def test_walking_away_is_no_danger_and_walking_into_the_way_is_one() -> None:
    x = FRONT + 2.5
    assert brake(a_track(x, HALF + 0.5, 0.0, 1.4), 3.0) == 0.0
    assert brake(a_track(x, HALF + 1.0, 0.0, -1.4), 3.0) > 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_who_has_just_set_off_into_the_way_is_braked_for_before_they_have_their_pace(side: float) -> None:
    """At 0.6 m/s they would let the vehicle pass; at the pace that they will have they meet its nose."""
    x, y, speed = FRONT + 1.3, side * (HALF + 0.25 + 0.8), 2.0
    assert brake(a_track(x, y, 0.0, -side * 0.6), speed) > 0.0
    assert brake(a_track(x, y, 0.0, -side * 0.4), speed) == 0.0, "so slow is also who stands, by the tracker"
    assert brake(a_track(x, y, 1.1, -side * 0.55), speed) == 0.0, "they walk along"
    assert brake(a_track(x, y, 0.0, side * 0.6), speed) == 0.0, "they walk away"


@pytest.mark.parametrize("gap", [-0.1, 0.05, 0.15, 0.3, 0.55])
@pytest.mark.parametrize("x", [-0.5, 1.0, 1.7])
def test_the_vehicle_does_not_brake_for_a_person_who_walks_into_its_flank(x: float, gap: float) -> None:
    assert brake(a_track(x, HALF + 0.25 + gap, 0.0, -1.4), 3.0) == 0.0


def test_the_vehicle_brakes_when_it_turns_towards_a_person_alongside() -> None:
    assert brake(a_track(0.0, -HALF - 0.28), 2.0, steer=0.0) == 0.0
    assert brake(a_track(0.0, -HALF - 0.28), 2.0, steer=0.45) > 0.0


def test_a_person_who_has_left_the_way_when_the_flank_arrives_is_no_danger() -> None:
    assert brake(a_track(FRONT + 2.0, HALF + 0.5, 0.0, 1.4), 3.0) == 0.0


def test_a_lead_vehicle_of_equal_speed_may_be_nearer_than_a_standing_one() -> None:
    x = FRONT + 0.5 * BODY.length_m + 2.2
    assert brake(a_track(x, 0.0, kind=VEHICLE), 4.0) > 0.0
    assert brake(a_track(x, 0.0, 4.0, kind=VEHICLE), 4.0) == 0.0
    assert brake(a_track(x - 1.8, 0.0, 4.0, kind=VEHICLE), 4.0) > 0.0


def test_braking_for_an_oncoming_cyclist_begins_farther_away() -> None:
    x = FRONT + 5.0
    assert brake(a_track(x, 0.0, kind=CYCLIST), 4.0) == 0.0
    assert brake(a_track(x, 0.0, -4.0, kind=CYCLIST), 4.0) > 0.0


def test_fleet_vehicles_removed_from_the_lidar_cells_count_too() -> None:
    behind = Pose2(FRONT + BODY.rear_overhang_m + 1.0, 0.0, 0.0)
    assert brake(others=(FleetVehicle(NOW_NS, "mate", behind, 0.0),), speed=3.0) > 0.0
    beside = Pose2(2.0, BODY.width_m + 0.8, math.pi)
    assert brake(others=(FleetVehicle(NOW_NS, "mate", beside, 3.0),), speed=3.0) == 0.0


def test_the_tail_swings_out_over_an_obstacle_alongside() -> None:
    beside_axle = (0.0, -HALF - 0.03)
    assert brake(points=(beside_axle,), speed=2.0, steer=0.0) == 0.0
    assert brake(points=(beside_axle,), speed=2.0, steer=0.45) > 0.0


def test_the_tail_swings_no_farther_than_it_reaches() -> None:
    behind_the_bumper = (-BODY.rear_overhang_m - 1.0, -HALF - 0.03)
    assert brake(points=(behind_the_bumper,), speed=2.0, steer=0.45) == 0.0


def test_somebody_far_away_hides_nobody_who_is_near() -> None:
    far, near = (FRONT + 15.0, 0.0), (FRONT + 1.0, 0.0)
    for points in ((far, near), (near, far)):
        assert brake(points=points, speed=3.0) == brake(points=(near,), speed=3.0) > 0.0


def may_set_off(*tracks: tuple[float, float], steer_rad: float = 0.0) -> bool:
    around = Tracks(
        NOW_NS,
        np.arange(len(tracks)),
        np.full(len(tracks), PEDESTRIAN),
        np.array([(x, y, 0.0) for x, y in tracks]),
        np.zeros((len(tracks), 2)),
        np.full((len(tracks), 2), 0.5),
    )
    world = World(NOW_NS, NOW_NS, np.empty((0, 2)), (), (), False, around)
    ego = Ego(NOW_NS, Pose2(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.02, NOW_NS, True)
    return AVOIDANCE.may_set_off(*AVOIDANCE.road_users(world, ego), steer_rad)


def test_nobody_is_driven_away_from_who_touches_the_flank_and_behind_the_bumper_all_may_stand() -> None:
    touches_the_rear_wheel = (-0.5, HALF + 0.25 - 0.02)
    right_behind = (-BODY.rear_overhang_m - 0.25 - 0.05, 0.0)
    assert not may_set_off(touches_the_rear_wheel)
    assert may_set_off(right_behind)
    assert not may_set_off(right_behind, touches_the_rear_wheel)


def test_who_walks_by_at_a_hand_s_breadth_from_the_flank_may_be_driven_away_from_but_not_turned_to() -> None:
    beside = (FRONT - 1.0, HALF + 0.25 + 0.05)
    at_the_corner = (FRONT - 0.2, HALF + 0.25 + 0.05)
    assert may_set_off(beside)
    assert not may_set_off(beside, steer_rad=0.45)
    assert not may_set_off(at_the_corner)


def test_the_inner_side_cuts_the_corner() -> None:
    inner = (2.2, HALF + 0.25)
    assert brake(points=(inner,), speed=2.5, steer=0.0) == 0.0
    assert brake(points=(inner,), speed=2.5, steer=0.45) > 0.0


def test_both_the_commanded_and_the_actual_angle_count() -> None:
    left = (FRONT + 1.0, 1.4)
    assert brake(points=(left,), speed=3.0) == 0.0
    assert brake(points=(left,), speed=3.0, steer=0.35, actual=0.0) > 0.0
    assert brake(points=(left,), speed=3.0, steer=0.0, actual=0.35) > 0.0


def test_a_track_is_extrapolated_from_its_stamp_to_now() -> None:
    tracks = a_track(FRONT + 0.25 + stopping_m(3.0) + 1.5, 0.0, -3.0)
    fresh = brake(tracks, 1.0)
    old = Tracks(
        NOW_NS - 500_000_000,
        tracks.ids,
        tracks.kinds,
        tracks.poses_map,
        tracks.velocities_map_mps,
        tracks.sizes_m,
    )
    assert (fresh, brake(old, 1.0) > 0.0) == (0.0, True)


def test_where_the_map_has_its_origin_makes_no_difference() -> None:
    pose = Pose2(300.0, -200.0, 2.0)
    x, y = FRONT + 2.0, 0.3
    there = (
        pose.x_m + x * math.cos(pose.yaw_rad) - y * math.sin(pose.yaw_rad),
        pose.y_m + x * math.sin(pose.yaw_rad) + y * math.cos(pose.yaw_rad),
    )
    assert brake(a_track(*there), 3.0, pose=pose) == brake(a_track(x, y), 3.0)


def test_the_brake_is_not_released_at_once() -> None:
    tracks = a_track(FRONT + 0.25 + stopping_m(3.0) + 0.6, 0.0)
    assert brake(tracks, 3.0) == 0.0
    assert brake(tracks, 3.0, braking=True) > 0.0


@given(
    x_m=st.floats(0.5, 6.0),
    y_m=st.floats(-3.0, 3.0),
    walks_mps=st.floats(-2.5, 2.5),
    speed=st.floats(0.5, 4.2),
)
def test_whom_the_vehicle_would_brake_for_it_goes_on_braking_for(
    x_m: float, y_m: float, walks_mps: float, speed: float
) -> None:
    """Also somebody whom it would just get past if it did not brake: it has braked by now."""
    walker = a_track(FRONT + x_m, y_m, 0.0, walks_mps)
    if brake(walker, speed) > 0.0:
        assert brake(walker, speed, braking=True) > 0.0


def test_clearance_is_the_distance_to_the_rectangle() -> None:
    assert clearance_m(5.0, 0.0, 1.0, 3.0, 1.0) == 2.0
    assert clearance_m(6.0, 5.0, 1.0, 3.0, 1.0) == 5.0
    assert clearance_m(1.0, 0.8, 1.0, 3.0, 1.0) == pytest.approx(-0.2)


def test_travel_is_response_and_then_braking() -> None:
    assert travel_m(10.0, 4.0, 0.0, 0.3, 5.0) == pytest.approx(4.0 * 0.3 + 16.0 / 10.0)
    assert travel_m(0.2, 4.0, 0.0, 0.3, 5.0) == pytest.approx(0.8)


@pytest.mark.parametrize(("x", "y", "may"), [(-1.05, 0.2, True), (1.0, 1.05, False), (3.8, 0.0, False)])
def test_only_a_person_behind_the_vehicle_does_not_keep_it_from_setting_off(
    x: float, y: float, may: bool
) -> None:
    ego = Ego(NOW_NS, Pose2(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.02, NOW_NS, True)
    world = World(NOW_NS, NOW_NS, np.empty((0, 2)), (), (), False, a_track(x, y))
    assert AVOIDANCE.may_set_off(*AVOIDANCE.road_users(world, ego), 0.0) is may


@pytest.mark.parametrize(("ahead_m", "touched"), [(0.9, True), (1.05, True), (1.2, False)])
def test_who_stands_ahead_may_have_stepped_nearer_by_the_end_of_braking(
    ahead_m: float, touched: bool
) -> None:
    """From 10 m/s with 5 m/s2 the vehicle stands after 2 s; by then a person deviates by 0.5 m/s2 t^2 / 2."""
    reach_m = travel_m(2.0, 10.0, 0.0, 0.0, 5.0)
    person = np.array([[FRONT + reach_m + ahead_m, 0.0, 0.0, 0.0, 0.0, 3.0, 0.5]])
    body = (BODY.rear_overhang_m, FRONT, HALF)
    assert will_touch(person, 0.0, 10.0, 0.0, 0.0, 5.0, body, 0.0, 0.1) == touched


def alongside_mps(tracks: Tracks) -> float:
    ego = Ego(NOW_NS, Pose2(0.0, 0.0, 0.0), 3.0, 0.0, 0.0, 0.0, 0.02, NOW_NS, True)
    world = World(NOW_NS, NOW_NS, np.empty((0, 2)), (), (), False, tracks)
    movers, _ = AVOIDANCE.road_users(world, ego)
    return AVOIDANCE.alongside_mps(movers)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("gap", "allowed_mps"), [(-0.1, 1.2), (0.0, 1.2), (0.1, 1.95), (0.2, 2.7), (0.39, 4.1), (0.41, math.inf)]
)
def test_the_nearer_somebody_walks_beside_the_vehicle_the_slower_it_passes(
    side: float, gap: float, allowed_mps: float
) -> None:
    for x in (-0.5, 1.0, FRONT - 0.1):
        beside = a_track(x, side * (HALF + 0.25 + gap), 1.2)
        assert alongside_mps(beside) == pytest.approx(allowed_mps, abs=0.05)


def test_a_cyclist_beside_the_vehicle_counts_and_a_vehicle_in_the_next_lane_does_not() -> None:
    assert alongside_mps(a_track(1.0, HALF + 0.3 + 0.1, 3.0, kind=CYCLIST)) == pytest.approx(1.95, abs=0.05)
    assert alongside_mps(a_track(1.0, HALF + 0.815 + 0.1, 3.0, kind=VEHICLE)) == math.inf


@pytest.mark.parametrize("x", [FRONT + 0.3, -BODY.rear_overhang_m - 0.3])
def test_people_before_the_bumper_and_behind_the_vehicle_are_not_alongside(x: float) -> None:
    assert alongside_mps(a_track(x, HALF + 0.3)) == math.inf


def test_who_is_before_a_corner_of_the_bumper_is_braked_for_although_the_vehicle_turns_away() -> None:
    """Within the extra room ahead, but aside of it: the turn leads past them by less than a centimetre."""
    corner = a_track(FRONT + 0.17, -(HALF + 0.195), -0.27, 0.29)
    assert brake(corner, 0.8, steer=0.39) > 0.0
    assert brake(a_track(FRONT + 0.17, -(HALF + 0.6)), 0.8, steer=0.39) == 0.0


@settings(max_examples=300, deadline=None)
@given(
    ahead=st.floats(0.0, 1.2),
    y=st.floats(-1.4, 1.4),
    vx=st.floats(-1.2, 1.2),
    vy=st.floats(-1.2, 1.2),
    speed=st.floats(0.55, 3.0),
    steer=st.floats(-0.4, 0.4),
)
def test_the_guard_brakes_before_the_gate_would(
    ahead: float, y: float, vx: float, vy: float, speed: float, steer: float
) -> None:
    """By the same percept on the same arc; the gate's stop needs an operator's resume."""
    x, gate = FRONT + ahead, gate_settings(Profile())
    disc = np.array([[x, y], [x - 0.25, y], [x + 0.25, y], [x, y - 0.25], [x, y + 0.25]])
    velocity, curvature = np.array([vx, vy]), math.tan(steer) / gate.wheelbase_m

    def is_met(after_s: float) -> bool:
        way_m = speed * after_s
        cos, sin = math.cos(curvature * way_m), math.sin(curvature * way_m)
        turn = np.array([[cos, -sin], [sin, cos]])
        return is_met_on_arc(
            np.ascontiguousarray((disc + after_s * velocity - np.array([way_m, 0.0])) @ turn),
            np.ascontiguousarray(np.tile(velocity @ turn, (len(disc), 1))),
            curvature,
            speed,
            gate.delay_s,
            gate.brake_mps2,
            gate.margin_m,
            gate.front_m,
            gate.half_width_m,
        )

    # It wants to see it in three steps; who walks away faster than the vehicle follows is left to it.
    if vx <= speed and is_met(0.0) and is_met(0.02) and is_met(0.04):
        assert brake(a_track(x, y, vx, vy), speed, steer=steer) > 0.0
