"""What the independent checker lets pass, and what it names as a violation: each bound from both sides."""

import math
from typing import Any

import msgspec
import numpy as np
import pytest

from contract.geometry import Array, Pose2, compose, transform_points
from tests.vehicle_agent.planning.motion.scenes import a_request, people
from vehicle_agent.planning.motion.checker import violations
from vehicle_agent.planning.motion.request import PASS_FREE, Agents, DrivingLimits, MotionRequest, Vehicle
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

CAR = Vehicle()
LIMITS = DrivingLimits()
FRONT_M = CAR.length_m - CAR.rear_overhang_m
HALF_M = 0.5 * CAR.width_m
T, X, Y, YAW, CURVATURE, SPEED, ACCEL, S = range(8)


def driven(
    speed_mps: float = 3.0, accel: Array | float = 0.0, curvature_1pm: float = 0.0, n: int = 41
) -> Array:
    """(n, 8) rows every 0.1 s from the origin; accel (n,) is linear between rows."""
    rows = np.zeros((n, 8))
    rows[:, T] = 0.1 * np.arange(n)
    rows[:, ACCEL] = accel
    a = rows[:, ACCEL]
    rows[1:, SPEED] = np.cumsum(0.05 * (a[1:] + a[:-1]))
    rows[:, SPEED] += speed_mps
    v = rows[:, SPEED]
    ways = 0.05 * (v[1:] + v[:-1]) - np.diff(a) * 0.01 / 12.0
    rows[1:, S] = np.cumsum(ways)
    rows[:, CURVATURE] = curvature_1pm
    rows[:, YAW] = curvature_1pm * rows[:, S]
    middle = 0.5 * (rows[1:, YAW] + rows[:-1, YAW])
    rows[1:, X] = np.cumsum(ways * np.cos(middle))
    rows[1:, Y] = np.cumsum(ways * np.sin(middle))
    return rows


def found(rows: Array, request: MotionRequest | None = None, *, emergency: bool = False) -> tuple[str, ...]:
    if request is None:
        request = a_request(speed_mps=float(rows[0, SPEED]), room_m=20.0)
    return violations(rows, request, CAR, LIMITS, emergency=emergency)


def changed(column: int, amount: float, first: int = 0, last: int | None = None) -> Array:
    """Steady driving at 3 m/s with one column off by an amount in these rows."""
    rows = driven()
    rows[first:last, column] += amount
    return rows


def ramped(to_mps2: float, jerk_mps3: float, speed_mps: float, n: int = 41) -> Array:
    """From no acceleration to to_mps2 at that jerk, and on like that."""
    rise = math.copysign(jerk_mps3, to_mps2) * 0.1 * np.arange(n)
    return driven(speed_mps, np.clip(rise, min(to_mps2, 0.0), max(to_mps2, 0.0)), n=n)


def stopping(speed_mps: float, decel_mps2: float, n: int = 41) -> Array:
    """Braking at once to a stand."""
    rows = driven(speed_mps, -decel_mps2, n=n)
    rest = rows[:, SPEED] <= 0.0
    rows[rest, SPEED] = rows[rest, ACCEL] = 0.0
    stop_m = 0.5 * speed_mps**2 / decel_mps2
    rows[rest, X] = rows[rest, S] = stop_m
    return rows


def test_steady_driving_on_the_line_violates_nothing() -> None:
    assert found(driven()) == ()
    assert found(driven(2.0, curvature_1pm=0.1)) == ()


def test_rows_that_are_too_few_or_not_finite_are_named_and_nothing_else() -> None:
    assert found(driven()[:1]) == ("empty",)
    for column in range(8):
        rows = driven()
        rows[7, column] = math.nan
        assert found(rows) == ("not_finite",)


@pytest.mark.parametrize(
    ("start", "within"),
    [
        ({"pose": (0.019, 0.0, 0.0)}, True),
        ({"pose": (0.021, 0.0, 0.0)}, False),
        ({"pose": (0.0, -0.019, 0.0)}, True),
        ({"pose": (0.0, -0.021, 0.0)}, False),
        ({"pose": (0.0, 0.0, 0.009)}, True),
        ({"pose": (0.0, 0.0, -0.011)}, False),
        ({"pose": (0.0, 0.0, 2.0 * math.pi)}, True),
        ({"speed_mps": 3.019}, True),
        ({"speed_mps": 2.979}, False),
    ],
)
def test_the_rows_begin_where_the_vehicle_is(start: dict[str, Any], within: bool) -> None:
    request = a_request(**({"speed_mps": 3.0, "room_m": 20.0} | start))
    assert found(driven(), request) == (() if within else ("start",))


def test_the_rows_begin_now_and_a_vehicle_that_rolls_back_begins_at_rest() -> None:
    late = driven()
    late[:, T] += 0.1
    assert "start" in found(late)
    standing = driven(0.0)
    assert found(standing, a_request(speed_mps=-0.3)) == ()


@pytest.mark.parametrize(
    ("column", "within", "beyond"),
    [(X, 0.009, 0.011), (Y, 0.009, 0.011), (YAW, 0.003, 0.011), (SPEED, 0.019, 0.03)],
)
def test_place_heading_and_speed_follow_from_one_row_to_the_next(
    column: int, within: float, beyond: float
) -> None:
    for sign in (1.0, -1.0):
        assert "kinematics" not in found(changed(column, sign * within, first=20))
        assert "kinematics" in found(changed(column, sign * beyond, first=20))


def test_rows_that_are_seconds_apart_are_judged_by_the_same_motion() -> None:
    rows = ramped(-0.8, 0.4, 4.0)[::20]
    assert rows[:, T].tolist() == pytest.approx([0.0, 2.0, 4.0])
    assert "kinematics" not in found(rows)
    rows[1:, X] += 0.02
    assert "kinematics" in found(rows)


def test_times_that_do_not_rise_are_inconsistent() -> None:
    assert "kinematics" in found(changed(T, -0.1, 20, 21))


def test_a_turn_that_the_curvature_does_not_make_is_inconsistent() -> None:
    rows = driven(2.0, curvature_1pm=0.1)
    rows[:, CURVATURE] = 0.149
    assert "kinematics" not in found(rows)
    rows[:, CURVATURE] = 0.151
    assert "kinematics" in found(rows)


def test_at_rest_the_acceleration_may_end_at_once() -> None:
    assert found(stopping(1.2, 0.8), a_request(speed_mps=1.2, accel_mps2=-0.8)) == ()


@pytest.mark.parametrize(("speed_mps", "within"), [(4.21, True), (4.23, False)])
def test_the_speed_limit_holds(speed_mps: float, within: bool) -> None:
    request = a_request(speed_mps=4.0, room_m=20.0)
    rows = ramped(0.0, 0.0, speed_mps)
    rows[0, SPEED] = 4.0
    assert ("speed" not in found(rows, request)) == within


def test_a_start_above_the_limit_comes_down_to_it_comfortably() -> None:
    speed_mps = 5.5
    quick, slow = (ramped(-decel, 1.7, speed_mps, n=31) for decel in (0.8, 0.2))
    assert "speed" not in found(quick)
    assert "speed" in found(slow)


def test_a_trajectory_does_not_go_backwards() -> None:
    assert "speed" in found(changed(SPEED, -3.01))


@pytest.mark.parametrize(
    ("accel_mps2", "within"), [(1.01, True), (1.03, False), (-1.81, True), (-1.83, False)]
)
def test_the_bounds_of_acceleration_hold(accel_mps2: float, within: bool) -> None:
    speed_mps = 0.5 if accel_mps2 > 0.0 else 4.0
    rows = ramped(accel_mps2, 1.6, speed_mps, n=21)
    assert found(rows) == (() if within else ("accel",))


def test_braking_beyond_the_ordinary_is_for_an_emergency() -> None:
    rows = ramped(-4.9, 25.0, 4.0, n=8)
    assert {"accel", "jerk"} <= set(found(rows))
    assert found(rows, emergency=True) == ()
    assert "accel" in found(ramped(-5.1, 25.0, 4.0, n=8), emergency=True)


@pytest.mark.parametrize(("accel_mps2", "rises"), [(1.5, False), (-2.4, True)])
def test_a_start_beyond_the_bounds_comes_back_to_them(accel_mps2: float, rises: bool) -> None:
    """At 1.4 m/s3 it is back in time; a start that stays beyond them is not."""
    t = 0.1 * np.arange(15)
    back = np.clip(accel_mps2 + (1.4 if rises else -1.4) * t, -1.8, 1.0)
    request = a_request(speed_mps=3.0, accel_mps2=accel_mps2, room_m=20.0)
    assert "accel" not in found(driven(3.0, back, n=15), request)
    assert "accel" in found(driven(3.0, accel_mps2, n=15), request)


@pytest.mark.parametrize(("jerk_mps3", "within"), [(1.74, True), (1.77, False)])
def test_the_bound_of_jerk_holds_in_both_directions(jerk_mps3: float, within: bool) -> None:
    for to_mps2 in (0.9, -0.9):
        assert ("jerk" not in found(ramped(to_mps2, jerk_mps3, 2.5, n=12))) == within


@pytest.mark.parametrize(("curvature_1pm", "within"), [(0.2019, True), (-0.2021, False), (0.2021, False)])
def test_the_steering_ends_at_its_stop(curvature_1pm: float, within: bool) -> None:
    assert found(driven(1.0, curvature_1pm=curvature_1pm)) == (() if within else ("curvature",))


def test_a_start_tighter_than_the_steering_allows_is_a_fact() -> None:
    request = a_request(speed_mps=1.0, curvature_1pm=-0.25, room_m=20.0)
    assert found(driven(1.0, curvature_1pm=-0.2549), request) == ()
    assert found(driven(1.0, curvature_1pm=-0.2551), request) == ("curvature",)


@pytest.mark.parametrize(("speed_mps", "within"), [(2.89, True), (2.91, False)])
def test_the_lateral_acceleration_keeps_its_bound(speed_mps: float, within: bool) -> None:
    for curvature_1pm in (0.1, -0.1):
        rows = driven(speed_mps, curvature_1pm=curvature_1pm)
        assert found(rows) == (() if within else ("lateral",))


def test_the_lateral_acceleration_of_the_start_may_only_fall() -> None:
    request = a_request(speed_mps=3.5, curvature_1pm=0.1, room_m=30.0)
    steady = driven(3.5, curvature_1pm=0.1)
    assert found(steady, request) == ("lateral",)
    assert found(steady[:4], request) == ()
    assert found(steady, request, emergency=True) == ()


@pytest.mark.parametrize(("offset_m", "within"), [(1.55, True), (1.57, False), (-1.55, True), (-1.57, False)])
def test_the_walls_are_hard(offset_m: float, within: bool) -> None:
    """A road whose walls stand 1.5 m away from 5 m on; before, there is room."""
    wide = a_request(speed_mps=3.0, pose=(0.0, offset_m, 0.0))
    room = np.where(wide.corridor.s_m < 5.0, 3.0, 1.5)
    request = msgspec.structs.replace(wide, lower_l_m=-room, upper_l_m=room)
    rows = driven()
    rows[:, Y] += offset_m
    assert found(rows, request) == (() if within else ("wall",))


def test_a_start_beyond_a_wall_only_comes_back() -> None:
    """From 2 m beyond: no farther out than 0.3 m more, and once inside never out again."""
    request = a_request(speed_mps=3.0, pose=(0.0, 3.5, -0.3))
    rows = driven()
    rows[:, YAW] = -0.3
    rows[:, X], rows[:, Y] = rows[:, S] * math.cos(0.3), 3.5 - rows[:, S] * math.sin(0.3)
    inside = rows[rows[:, Y] > -1.5]
    assert "wall" not in found(inside, request)
    assert "wall" in found(np.vstack((inside[:-1], rows[-1:] - [0, 0, 2.0, 0, 0, 0, 0, 0])), request)
    away = rows.copy()
    away[:, YAW], away[:, Y] = 0.3, 3.5 + rows[:, S] * math.sin(0.3)
    assert "wall" in found(away, a_request(speed_mps=3.0, pose=(0.0, 3.5, 0.3)))


def test_a_drive_that_came_back_from_beyond_a_wall_does_not_leave_again() -> None:
    request = a_request(speed_mps=3.0, pose=(0.0, 3.5, 0.0))
    rows = driven()
    rows[:10, Y] = 3.5
    assert "wall" not in found(rows, request)
    rows[11:14, Y] = 2.0
    assert "wall" in found(rows, request)


@pytest.mark.parametrize(("gap_m", "within"), [(0.01, True), (-0.01, False)])
def test_nothing_that_stands_is_touched_by_any_side_of_the_body(gap_m: float, within: bool) -> None:
    end_m = 12.0
    for disc in (
        (end_m + FRONT_M + 0.3 + gap_m, 0.0),
        (6.0, HALF_M + 0.3 + gap_m),
        (6.0, -HALF_M - 0.3 - gap_m),
        (end_m + FRONT_M + (0.3 + gap_m) * 0.6, HALF_M + (0.3 + gap_m) * 0.8),
    ):
        request = a_request(speed_mps=3.0, static_discs=np.array([[*disc, 0.3]]))
        assert found(driven(), request) == (() if within else ("static",)), disc


def elsewhere(rows: Array, request: MotionRequest) -> tuple[Array, MotionRequest]:
    """The same scene 30 m to the east and 12 m to the south, turned by 2.5 rad to the left."""
    there = Pose2(30.0, -12.0, 2.5)

    def moved(table: Array, x: int) -> Array:
        copy: Array = np.array(table)
        places = table[..., x : x + 2]
        copy[..., x : x + 2] = transform_points(there, places.reshape(-1, 2)).reshape(places.shape)
        return copy

    rows, poses = moved(rows, X), moved(request.agents.poses_map, 0)
    rows[:, YAW] += there.yaw_rad
    poses[..., 2] += there.yaw_rad
    corridor, replace = request.corridor, msgspec.structs.replace
    return rows, replace(
        request,
        start=replace(request.start, pose_map=compose(there, request.start.pose_map)),
        agents=replace(request.agents, poses_map=poses),
        static_discs=moved(request.static_discs, 0),
        corridor=replace(
            corridor, points_map=moved(corridor.points_map, 0), yaw_rad=corridor.yaw_rad + there.yaw_rad
        ),
    )


@pytest.mark.parametrize(("stop_m", "within"), [(7.95, True), (8.2, False)])
def test_where_the_room_narrows_the_walls_are_where_they_are_between_its_points_too(
    stop_m: float, within: bool
) -> None:
    """A wall comes in at 1:2 and is met after 8 m; its points are half a metre apart."""
    wide = a_request(speed_mps=2.0, accel_mps2=-2.0 / stop_m, pose=(0.0, 1.5, 0.0))
    room = np.interp(wide.corridor.s_m, [5.0, 11.0], [3.0, 0.0])
    request = msgspec.structs.replace(wide, lower_l_m=-room, upper_l_m=room)
    rows = stopping(2.0, 2.0 / stop_m, n=100)
    rows[:, Y] += 1.5
    assert ("wall" not in found(rows, request)) == within
    assert ("wall" not in found(*elsewhere(rows, request))) == within


CART = {"kinds": np.full(1, VEHICLE, dtype=np.int64), "sizes_m": np.array([[2.4, 0.6]])}


@pytest.mark.parametrize(
    "scene",
    [
        {},
        {"static_discs": np.array([[6.0, HALF_M + 0.31, 0.3], [-CAR.rear_overhang_m - 0.1, 0.0, 0.3]])},
        {"static_discs": np.array([[6.0, -HALF_M - 0.29, 0.3]])},
        {"agents": people((9.0, -1.4 * (9.0 - FRONT_M) / 3.0, 0.0, 1.4))},
        {"agents": people((6.0, HALF_M + 0.5, 2.0, 0.0))},
        {"agents": msgspec.structs.replace(people((9.0, HALF_M + 0.25, 1e-3, 0.0)), **CART)},
        {"agents": msgspec.structs.replace(people((9.0, HALF_M + 0.25, 0.0, 1e-3)), **CART)},
        {"agents": msgspec.structs.replace(people((-CAR.rear_overhang_m - 1.0, 0.0, 2.0, 0.0)), **CART)},
    ],
)
def test_where_on_the_map_and_which_way_a_drive_goes_does_not_matter(scene: dict[str, Any]) -> None:
    request = a_request(speed_mps=3.0, room_m=20.0, **scene)
    assert found(*elsewhere(driven(), request)) == found(driven(), request)


def test_what_already_touches_the_rear_does_not_keep_the_vehicle() -> None:
    behind = a_request(speed_mps=3.0, static_discs=np.array([[-CAR.rear_overhang_m - 0.1, 0.0, 0.3]]))
    assert found(driven(), behind) == ()


def test_somebody_or_something_inside_the_outline_asks_for_a_stop_at_once() -> None:
    for inside in (
        {"static_discs": np.array([[FRONT_M, 0.0, 0.3]])},
        {"agents": people((FRONT_M - 0.2, 0.3, 0.0, 0.0))},
    ):
        request = a_request(speed_mps=1.5, accel_mps2=-1.5, **inside)
        assert "footprint" in found(driven(1.5), request)
        assert "footprint" not in found(stopping(1.5, 1.5), request)
        assert "footprint" in found(stopping(1.5, 0.6), request)


@pytest.mark.parametrize(("early_s", "within"), [(0.0, False), (1.5, True)])
def test_somebody_who_crosses_is_not_met_by_the_nose(early_s: float, within: bool) -> None:
    """They reach the line 9 m ahead together with the bumper, or that much earlier."""
    at_s = (9.0 - FRONT_M) / 3.0
    request = a_request(speed_mps=3.0, agents=people((9.0, -1.4 * (at_s - early_s), 0.0, 1.4)))
    assert found(driven(), request) == (() if within else ("agent",))


@pytest.mark.parametrize(
    ("from_y_m", "met"), [(-3.5, True), (-5.0, True), (-8.0, False), (-1.5, False), (1.0, False)]
)
def test_between_two_predicted_times_people_go_straight_on(from_y_m: float, met: bool) -> None:
    """Predicted for two moments, for three, or every tenth of a second."""
    for times_s in (np.array([0.0, 4.0]), np.array([0.0, 0.7, 4.0]), np.linspace(0.0, 4.0, 41)):
        poses = np.zeros((1, len(times_s), 3))
        poses[0, :, 0] = 7.0 + 0.5 * times_s
        poses[0, :, 1] = from_y_m + 2.0 * times_s
        crosses = Agents(
            np.array([1]),
            np.array([PEDESTRIAN]),
            times_s,
            poses,
            np.array([[0.5, 0.5]]),
            np.zeros((1, len(times_s))),
            np.array([PASS_FREE]),
        )
        wrong = found(driven(), a_request(speed_mps=3.0, room_m=20.0, agents=crosses))
        assert wrong == (("agent",) if met else ()), len(times_s)


def test_people_meet_only_the_nose_and_vehicles_the_whole_body() -> None:
    """Somebody walks into the flank 2 m behind the bumper."""
    at_s, x_m = 2.0, 6.0 + FRONT_M - 2.0
    walker = people((x_m, HALF_M + 0.2 + 1.0 * at_s, 0.0, -1.0))
    assert found(driven(), a_request(speed_mps=3.0, agents=walker)) == ()
    cart = msgspec.structs.replace(
        walker, kinds=np.full(1, VEHICLE, dtype=np.int64), sizes_m=np.array([[1.0, 0.5]])
    )
    assert found(driven(), a_request(speed_mps=3.0, agents=cart)) == ("agent",)


@pytest.mark.parametrize(("turned_rad", "met"), [(0.0, False), (0.5 * math.pi, True)])
def test_a_cart_that_turns_is_met_as_it_will_stand_then(turned_rad: float, met: bool) -> None:
    """Now it is parallel to the way and beside it."""
    cart = people((9.0, HALF_M + 0.6, 0.0, 0.0))
    poses = np.repeat(cart.poses_map[:, :1], 2, axis=1)
    poses[0, 0, 2], poses[0, 1, 2] = 0.0, turned_rad
    turning = msgspec.structs.replace(
        cart, times_s=np.array([0.0, 4.0]), poses_map=poses, inflation_m=np.zeros((1, 2)), **CART
    )
    wrong = found(driven(), a_request(speed_mps=3.0, room_m=20.0, agents=turning))
    assert wrong == (("agent",) if met else ())


@pytest.mark.parametrize("axis", [0, 1])
def test_an_agent_that_cannot_be_true_is_not_checked(axis: int) -> None:
    jumps = people((9.0, 0.0, 0.0, 0.0))
    jumps.poses_map[0, 30:, axis] += 500.0
    assert found(driven(), a_request(speed_mps=3.0, agents=jumps)) == ()


@pytest.mark.parametrize(("end_m", "within"), [(3.0, True), (2.79, True), (2.55, False), (2.4, False)])
def test_it_stands_before_the_place_where_it_must(end_m: float, within: bool) -> None:
    """Braking with 0.8 m/s2 from 2 m/s takes 2.5 m, to be had within 0.1 m."""
    rows = stopping(2.0, 0.8)
    request = a_request(speed_mps=2.0, accel_mps2=-0.8, end_s_m=end_m - 0.2)
    assert rows[-1, S] == pytest.approx(2.5)
    assert ("end" not in found(rows, request)) == within


def test_at_the_end_of_the_rows_it_can_still_stop() -> None:
    rows = driven(3.0, n=11)
    needed_m = 3.0 + 9.0 / (2.0 * LIMITS.decel_mps2_max)
    assert found(rows, a_request(speed_mps=3.0, end_s_m=needed_m - 0.19)) == ()
    assert found(rows, a_request(speed_mps=3.0, end_s_m=needed_m - 0.21)) == ("end",)


@pytest.mark.parametrize("end_m", [2.0, 2.7])
def test_a_start_too_near_and_too_fast_is_asked_to_stop_at_once(end_m: float) -> None:
    """It stands after 3 m."""
    request = a_request(speed_mps=3.0, accel_mps2=-1.5, end_s_m=end_m)
    assert "end" not in found(stopping(3.0, 1.5), request)
    assert "end" in found(stopping(3.0, 0.8, n=61), request)
    assert "end" in found(driven(3.0), request)


@pytest.mark.parametrize(("end_m", "within"), [(3.95, True), (3.6, False)])
def test_such_a_start_may_also_roll_on_slowly_as_long_as_it_stands_before_the_place(
    end_m: float, within: bool
) -> None:
    """It brakes to 0.45 m/s, rolls, and stands 3.87 m on."""
    at_s = 0.1 * np.arange(61)
    rows = driven(3.0, np.select([at_s < 1.65, at_s < 3.25, at_s < 3.85], [-1.5, 0.0, -0.9], 0.0), n=61)
    rows[:, SPEED] = np.maximum(rows[:, SPEED], 0.0)
    assert rows[-1, SPEED] < 0.05
    assert 3.8 < rows[-1, S] < 3.9
    request = a_request(speed_mps=3.0, accel_mps2=-1.5, end_s_m=end_m)
    assert ("end" not in found(rows, request)) == within
