"""Egos, worlds, tasks and lines with defaults."""

import numpy as np

from contract.geometry import Pose2, arc_lengths, curvatures
from contract.roads.routing import ReferenceLine
from vehicle_agent.config import Profile
from vehicle_agent.planning.waypoint.waypoint_planning import WaypointPlanning
from vehicle_agent.signals import Ego, FleetVehicle, Task, TaskMode, World
from vehicle_agent.stacks.rooms import waypoint_planning

ROOM: WaypointPlanning = waypoint_planning(Profile())
TICK_NS = 20_000_000


def a_line(length_m: float = 100.0, limit_mps: float = 5.0) -> ReferenceLine:
    points = np.column_stack((np.arange(0.0, length_m + 1.0), np.zeros(round(length_m) + 1)))
    n = len(points)
    return ReferenceLine(
        points,
        arc_lengths(points),
        curvatures(points),
        np.full(n, limit_mps),
        np.zeros(n, np.int64),
        ("east",),
        (("east/0", 0.0, length_m),),
    )


def an_ego(now_ns: int, x_m: float = 20.0, speed_mps: float = 3.0, std_m: float = 0.02) -> Ego:
    return Ego(now_ns, Pose2(x_m, 0.0, 0.0), speed_mps, 0.0, 0.0, 0.0, std_m, now_ns, True)


def a_world(*points: tuple[float, float], seen_ns: int = 1, others: tuple[FleetVehicle, ...] = ()) -> World:
    return World(seen_ns, seen_ns, np.array(points, dtype=np.float64).reshape(-1, 2), others, (), False)


def a_task(s_m: float = 20.0, stop_s_m: float = 90.0, mode: TaskMode = "drive", waiting: str = "") -> Task:
    return Task(
        mode, a_line(), 1, s_m, 0.0, stop_s_m, "east", s_m, "o", 1, "v", "", "", False, (), waiting, None
    )
