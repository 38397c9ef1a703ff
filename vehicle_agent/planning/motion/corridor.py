"""The task's line at even steps, with map data by station: the input of motion plans."""

import math

import numpy as np
from scipy.interpolate import CubicSpline

from contract.geometry import Array
from contract.roads.model import SCENARIOS
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine
from contract.roads.width import drivable_width
from vehicle_agent.signals import Corridor

STEP_M = 0.5
# The line continues straight this far before its start and after its end, so that a body on either still has
# a frame.
BEYOND_M = 12.0
_SCENARIO_NUMBER = {name: number for number, name in enumerate(SCENARIOS)}


def corridor_of(line: ReferenceLine, network: RoadNetwork) -> Corridor:
    """The whole line, BEYOND_M longer at both ends; a line of one point gives an empty corridor.

    Places, headings and curvature are those of the C2 spline through the line's points: chords of a metre
    would bend by jumps.
    """
    length_m = float(line.s[-1])
    if len(line.points) < 3 or length_m < STEP_M:
        return NO_CORRIDOR
    spline = CubicSpline(line.s, line.points)
    inside: Array = np.arange(0.0, length_m, STEP_M)
    count = round(BEYOND_M / STEP_M)
    s = np.concatenate(
        (
            -STEP_M * np.arange(count, 0, -1),
            inside,
            inside[-1] + STEP_M * np.arange(1, count + 1),
        )
    )
    held = np.clip(s, 0.0, length_m)
    slope, bend = spline(held, 1), spline(held, 2)
    yaw = np.unwrap(np.arctan2(slope[:, 1], slope[:, 0]))
    over = s - held
    points = spline(held) + over[:, None] * np.column_stack((np.cos(yaw), np.sin(yaw)))
    speed2 = slope[:, 0] ** 2 + slope[:, 1] ** 2
    curvature = (slope[:, 0] * bend[:, 1] - slope[:, 1] * bend[:, 0]) / np.maximum(speed2, 1e-9) ** 1.5
    curvature[over != 0.0] = 0.0
    lane = line.lane_number[np.clip(np.searchsorted(line.s, held, side="right") - 1, 0, len(line.s) - 1)]
    lanes = [network.lanes[lane_id] for lane_id in line.lane_ids]
    left_m, right_m = drivable_width(network, line, network.road_map.buildings)
    scenario = np.array([_SCENARIO_NUMBER[item.scenario] for item in lanes], dtype=np.int64)[lane]
    limit = np.array([item.speed_limit_mps for item in lanes])[lane]
    return Corridor(
        np.ascontiguousarray(s),
        np.ascontiguousarray(points),
        yaw,
        curvature,
        np.ascontiguousarray(limit, dtype=np.float64),
        np.interp(held, line.s, left_m),
        np.interp(held, line.s, right_m),
        scenario,
    )


def window(whole: Corridor, s_m: float, behind_m: float, ahead_m: float) -> Corridor:
    """Its stations from behind_m before to ahead_m after a place on the line."""
    first = max(0, math.floor((s_m - behind_m - float(whole.s_m[0])) / STEP_M))
    last = min(len(whole.s_m), math.ceil((s_m + ahead_m - float(whole.s_m[0])) / STEP_M) + 1)
    part = slice(first, max(first, last))
    return Corridor(
        whole.s_m[part],
        whole.points_map[part],
        whole.yaw_rad[part],
        whole.curvature_1pm[part],
        whole.limit_mps[part],
        whole.left_m[part],
        whole.right_m[part],
        whole.scenario[part],
    )


NO_CORRIDOR = Corridor(
    np.empty(0),
    np.empty((0, 2)),
    np.empty(0),
    np.empty(0),
    np.empty(0),
    np.empty(0),
    np.empty(0),
    np.empty(0, np.int64),
)
