"""Which outlines the independent checker lets touch, against polygons of an independent library."""

import math
from typing import Any

import msgspec
import numpy as np
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely.affinity import rotate, translate

from contract.geometry import Array, Pose2, compose
from tests.vehicle_agent.planning.motion.scenes import a_corridor, a_request, people
from vehicle_agent.planning.motion.checker import violations
from vehicle_agent.planning.motion.request import DrivingLimits, Vehicle
from vehicle_agent.signals import VEHICLE

CAR = Vehicle()
FRONT_M = CAR.length_m - CAR.rear_overhang_m
SPEED_MPS, ROWS = 3.0, 31
# Closer than this to touching, the answer is rounding.
DOUBT_M = 1e-3

headings = st.floats(-3.1, 3.1)
places = st.tuples(st.floats(-4.0, 16.0), st.floats(-4.0, 4.0))


def straight(start: Pose2) -> Array:
    """(n, 8) rows of steady driving from a pose on."""
    rows = np.zeros((ROWS, 8))
    rows[:, 0] = 0.1 * np.arange(ROWS)
    rows[:, 7] = SPEED_MPS * rows[:, 0]
    rows[:, 1] = start.x_m + rows[:, 7] * math.cos(start.yaw_rad)
    rows[:, 2] = start.y_m + rows[:, 7] * math.sin(start.yaw_rad)
    rows[:, 3], rows[:, 5] = start.yaw_rad, SPEED_MPS
    return rows


def outline(back_m: float, front_m: float, width_m: float, x: float, y: float, yaw: float) -> shapely.Polygon:
    box = shapely.box(-back_m, -0.5 * width_m, front_m, 0.5 * width_m)
    return translate(rotate(box, yaw, (0.0, 0.0), use_radians=True), x, y)


def bodies(rows: Array, length_m: float = CAR.length_m) -> list[shapely.Polygon]:
    """The vehicle at each row, or this length of it from the bumper back."""
    return [outline(length_m - FRONT_M, FRONT_M, CAR.width_m, x, y, yaw) for x, y, yaw in rows[:, 1:4]]


def touching(ours: list[shapely.Polygon], theirs: list[shapely.Polygon], radius_m: float = 0.0) -> list[bool]:
    """Row by row; cases too close to call are left out."""
    gaps_m = []
    for mine, other in zip(ours, theirs, strict=True):
        gap_m = mine.distance(other) - radius_m
        overlaps = mine.intersection(other).area if gap_m <= 0.0 and other.area else 1.0
        assume(abs(gap_m) > DOUBT_M if radius_m or gap_m > 0.0 else overlaps > DOUBT_M)
        gaps_m.append(gap_m)
    return [gap_m <= 0.0 for gap_m in gaps_m]


def found(rows: Array, **scene: Any) -> set[str]:
    """What the checker says of outlines."""
    start = Pose2(*rows[0, 1:4])
    request = a_request(a_corridor(), pose=(0.0, 0.0, 0.0), speed_mps=SPEED_MPS, room_m=100.0, **scene)
    request = msgspec.structs.replace(request, start=msgspec.structs.replace(request.start, pose_map=start))
    return {"agent", "static", "footprint"} & set(violations(rows, request, CAR, DrivingLimits()))


def behind(start: Pose2, x: float, y: float) -> bool:
    """The middle of something is behind the rear bumper at the start."""
    along = (x - start.x_m) * math.cos(start.yaw_rad) + (y - start.y_m) * math.sin(start.yaw_rad)
    assume(abs(along + CAR.rear_overhang_m) > DOUBT_M)
    return along < -CAR.rear_overhang_m


@settings(max_examples=150, deadline=None)
@given(place=places, yaw=headings, turn=headings, length_m=st.floats(0.8, 4.5), course=headings)
def test_another_vehicle_is_touched_exactly_where_the_outlines_overlap(
    place: tuple[float, float], yaw: float, turn: float, length_m: float, course: float
) -> None:
    start = Pose2(20.0, -7.0, turn)
    rows = straight(start)
    there = compose(start, Pose2(*place, yaw))
    vx, vy = 0.8 * math.cos(course), 0.8 * math.sin(course)
    cart = people((there.x_m, there.y_m, vx, vy))
    cart.poses_map[..., 2] = there.yaw_rad
    size = (length_m, 0.5 * length_m)
    cart = msgspec.structs.replace(cart, kinds=np.full(1, VEHICLE, dtype=np.int64), sizes_m=np.array([size]))
    theirs = [
        outline(0.5 * size[0], 0.5 * size[0], size[1], there.x_m + vx * t, there.y_m + vy * t, there.yaw_rad)
        for t in rows[:, 0]
    ]
    touched = touching(bodies(rows), theirs)
    expected = set()
    if touched[0]:
        expected.add("footprint")
    elif any(touched) and not behind(start, there.x_m, there.y_m):
        expected.add("agent")
    assert found(rows, agents=cart) == expected


def kept_out(start: Pose2, ways: list[tuple[float, float]], radius_m: float) -> list[shapely.Point]:
    """The places of somebody who does not walk on through a flank of the body at the start, but along it."""
    clear_m, corner_m = 0.5 * CAR.width_m + radius_m, FRONT_M - 0.3
    side, before, found = 0.0, None, []
    cos, sin = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    may_be_held = True
    for x, y in ways:
        dx, dy = x - start.x_m, y - start.y_m
        along, across = cos * dx + sin * dy, cos * dy - sin * dx
        for edge_m in (abs(along + CAR.rear_overhang_m), abs(along - corner_m), abs(abs(across) - clear_m)):
            assume(edge_m > DOUBT_M)
        if side == 0.0 and -CAR.rear_overhang_m < along < corner_m and abs(across) < clear_m:
            was_beside = abs(across) > 0.5 * CAR.width_m - 0.05 if before is None else abs(before) > clear_m
            if may_be_held and was_beside:
                side = math.copysign(1.0, across if before is None else before)
            may_be_held = False
        if side:
            across = side * max(side * across, clear_m + 2.0 * DOUBT_M)
        before = across
        found.append(
            shapely.Point(start.x_m + cos * along - sin * across, start.y_m + sin * along + cos * across)
        )
    return found


@settings(max_examples=150, deadline=None)
@given(place=places, turn=headings, radius_m=st.floats(0.1, 0.8), course=headings)
def test_a_person_is_touched_exactly_where_the_nose_meets_their_disc(
    place: tuple[float, float], turn: float, radius_m: float, course: float
) -> None:
    start = Pose2(20.0, -7.0, turn)
    rows = straight(start)
    there = compose(start, Pose2(*place, 0.0))
    vx, vy = 0.8 * math.cos(course), 0.8 * math.sin(course)
    person = msgspec.structs.replace(
        people((there.x_m, there.y_m, vx, vy)), sizes_m=np.array([[radius_m, 2.0 * radius_m]])
    )
    ways = [(there.x_m + vx * t, there.y_m + vy * t) for t in rows[:, 0]]
    middles = kept_out(start, ways, radius_m)
    inside = touching(bodies(rows), middles, radius_m)[0]
    met = touching(bodies(rows, CAR.nose_m), middles, radius_m)
    expected = set()
    if not behind(start, there.x_m, there.y_m):
        expected |= {"footprint"} if inside else set()
        expected |= {"agent"} if any(met) and not met[0] else set()
    assert found(rows, agents=person) == expected


@settings(max_examples=150, deadline=None)
@given(place=places, turn=headings, radius_m=st.floats(0.1, 0.8))
def test_what_stands_is_touched_exactly_where_the_body_meets_its_disc(
    place: tuple[float, float], turn: float, radius_m: float
) -> None:
    start = Pose2(20.0, -7.0, turn)
    rows = straight(start)
    there = compose(start, Pose2(*place, 0.0))
    touched = touching(bodies(rows), [shapely.Point(there.x_m, there.y_m)] * ROWS, radius_m)
    expected = set()
    if touched[0]:
        expected |= set() if behind(start, there.x_m, there.y_m) else {"footprint"}
    elif any(touched):
        expected.add("static")
    discs = np.array([[there.x_m, there.y_m, radius_m]])
    assert found(rows, static_discs=discs) == expected
