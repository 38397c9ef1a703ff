"""Builders of motion requests: a road, a start, people."""

import math
from typing import Any

import numpy as np

from contract.geometry import Array, Pose2
from vehicle_agent.planning.motion.request import Agents, MotionRequest, StartState
from vehicle_agent.signals import PEDESTRIAN, Corridor


def a_corridor(curvature_1pm: float = 0.0, length_m: float = 60.0, limit_mps: float = 4.17) -> Corridor:
    """A straight or circular line from 5 m behind s = 0 on, at even half metres."""
    s = 0.5 * np.arange(round(length_m / 0.5) + 1) - 5.0
    turn = curvature_1pm * s
    half = np.sinc(0.5 * turn / math.pi)
    points = np.column_stack([s * half * np.cos(0.5 * turn), s * half * np.sin(0.5 * turn)])
    one = np.ones(len(s))
    none = np.zeros(len(s), np.int64)
    return Corridor(s, points, turn, curvature_1pm * one, limit_mps * one, 3.0 * one, 3.0 * one, none)


def a_request(corridor: Corridor | None = None, **changed: Any) -> MotionRequest:
    """On the line at s = 0, 1.5 m of room on each side; also pose, speed_mps, accel_mps2, curvature_1pm."""
    corridor = corridor or a_corridor()
    start = StartState(
        Pose2(*changed.pop("pose", (0.0, 0.0, 0.0))),
        changed.pop("speed_mps", 0.0),
        changed.pop("accel_mps2", 0.0),
        changed.pop("curvature_1pm", 0.0),
    )
    room_m = changed.pop("room_m", 1.5)
    wide = np.full(len(corridor.s_m), room_m)
    values: dict[str, Any] = {
        "reference_l_m": 0.0 * wide,
        "lower_l_m": -wide,
        "upper_l_m": wide,
        "speed_mps_max": corridor.limit_mps,
    }
    return MotionRequest(corridor, start, **(values | changed))


def people(*walks: tuple[float, float, float, float]) -> Agents:
    """Pedestrians (x, y, vx, vy) at constant velocity for 8 s."""
    t = 0.25 * np.arange(33)
    count = len(walks)
    poses: Array = np.zeros((count, 33, 3))
    for i, (x, y, vx, vy) in enumerate(walks):
        poses[i] = np.column_stack([x + vx * t, y + vy * t, np.full(33, math.atan2(vy, vx))])
    return Agents(
        np.arange(count),
        np.full(count, PEDESTRIAN, dtype=np.int64),
        t,
        poses,
        np.full((count, 2), 0.5),
        np.zeros((count, 33)),
        np.zeros(count, np.int64),
    )
