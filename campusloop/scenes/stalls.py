"""Stalls: long stands although there was room to pass."""

import math

import numpy as np

from campusloop.scenes.contact_metrics import clearances
from campusloop.scenes.drive import Scene, SceneRun
from campusloop.scenes.path_map import LANE_ID
from contract.geometry import Array, arc_lengths, project
from vehicle_agent.config import Body

STALL_S = 20.0
GAP_WIDTHS = 1.5
_AHEAD_M = 8.0
_STANDS_MPS = 0.1
# The vehicle starts from rest in the first seconds.
_FROM_S = 3.0
_EVERY_ROWS = 25


def stalls(run: SceneRun, scene: Scene) -> int:
    """How many times the vehicle stood for more than STALL_S while there was room to pass.

    Room is checked every half second. There is room if a straight corridor GAP_WIDTHS of the vehicle's width
    wide, inside the lane, passes all agents within the next _AHEAD_M, and no agent is inside the outline.
    Recorded people do not see the vehicle and may walk through it while it stands; it must not move then.
    """
    rows, body = run.trace.array(), scene.profile.body
    lane = next(lane for lane in scene.road_map.lanes if lane.lane_id == LANE_ID)
    points = np.array(lane.points)
    s = arc_lengths(points)
    needed_m = GAP_WIDTHS * body.width_m
    count, begun_s, counted = 0, math.inf, False
    for k in range(0, len(rows), _EVERY_ROWS):
        t_s, speed_mps = float(rows[k, 0]), abs(float(rows[k, 4]))
        stands = speed_mps < _STANDS_MPS and t_s > _FROM_S
        if (
            not stands
            or _is_entered(run, k, body)
            or not _has_gap(run, k, points, s, lane.width_m, body.front_overhang_m, needed_m)
        ):
            begun_s, counted = math.inf, False
            continue
        begun_s = min(begun_s, t_s)
        if t_s - begun_s > STALL_S and not counted:
            count, counted = count + 1, True
    return count


def _is_entered(run: SceneRun, k: int, body: Body) -> bool:
    row, bodies = run.trace.array()[k], run.trace.agents[k]
    clearance, _ = clearances(
        float(row[1]),
        float(row[2]),
        float(row[3]),
        body.rear_overhang_m,
        body.front_overhang_m,
        0.5 * body.width_m,
        bodies.poses_map,
        bodies.sizes_m,
        bodies.people,
    )
    return bool((clearance < 0.0).any())


def _has_gap(
    run: SceneRun, k: int, points: Array, s: Array, width_m: float, front_m: float, needed_m: float
) -> bool:
    row, bodies = run.trace.array()[k], run.trace.agents[k]
    s_m, _, segment = project(points, s, float(row[1]), float(row[2]), 0, len(points))
    occupied = []
    for pose, size in zip(bodies.poses_map, bodies.sizes_m, strict=True):
        at_s, d_m, _ = project(points, s, float(pose[0]), float(pose[1]), segment - 2, segment + 40)
        reach_m = 0.5 * float(np.hypot(*size)) if size[0] != size[1] else 0.5 * float(size[0])
        if front_m - 0.5 <= at_s - s_m <= front_m + _AHEAD_M + reach_m and abs(d_m) < width_m:
            occupied.append((d_m - reach_m, d_m + reach_m))
    return widest_gap_m(occupied, 0.5 * width_m) >= needed_m


def widest_gap_m(occupied: list[tuple[float, float]], half_m: float) -> float:
    """The widest free interval of [-half_m, half_m] between the occupied ones."""
    edge, widest = -half_m, 0.0
    for low, high in sorted(occupied):
        widest = max(widest, min(low, half_m) - edge)
        edge = max(edge, high)
    return max(widest, half_m - edge)
