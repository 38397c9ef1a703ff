"""The best result of braking alone in a protection cell: the impact speed, or no contact.

The target is detected when its nearest point, or of a car any corner, is in line of sight and it is no longer
harmless. The vehicle stays on its path and brakes at 5.6 m/s2 from 0.27 s later, until it stands.
"""

import math
from dataclasses import dataclass

import numpy as np

from campusloop.scenes.contact_metrics import MOVING_MPS, clearances
from campusloop.scenes.protection.cell import RANGES_M, Cell
from contract.geometry import Array, arc_lengths, pose_at
from simulator.sensors.line_of_sight import visible
from simulator.traffic.actors import Bodies
from simulator.traffic.replayed import ReplayedTraffic
from vehicle_agent.config import Body
from vehicle_agent.signals import VEHICLE

DEAD_S, DECEL_MPS2 = 0.27, 5.6
_STEP_S = 0.01
_LASTS_S = 30.0


@dataclass(frozen=True, slots=True)
class OracleResult:
    """impact_mps: of a front contact, None without one; seen_s: when the target came into sight."""

    impact_mps: float | None
    seen_s: float | None


def best_braking(cell: Cell, body: Body, sensor_x_m: float) -> OracleResult:
    """The oracle's run of a cell."""
    s = arc_lengths(np.ascontiguousarray(cell.path))
    traffic = ReplayedTraffic(cell.clip, 0.0)
    at_m, speed_mps, seen_s = cell.start_s_m, cell.speed_mps, None
    outline = (body.rear_overhang_m, body.front_overhang_m, 0.5 * body.width_m)
    for k in range(round(_LASTS_S / _STEP_S)):
        t_s = k * _STEP_S
        traffic.clock_s = t_s
        bodies = traffic.bodies()
        x_m, y_m, yaw_rad = pose_at(cell.path, s, at_m)
        if (
            seen_s is None
            and t_s >= cell.harmless_s
            and _sees(bodies, x_m, y_m, yaw_rad, sensor_x_m, RANGES_M[cell.light])
        ):
            seen_s = t_s
        clearance, ahead = clearances(
            x_m, y_m, yaw_rad, *outline, bodies.poses_map, bodies.sizes_m, bodies.people
        )
        target = bodies.numbers == 1
        touches = target & (clearance < 0.0) & (ahead > body.front_overhang_m - 0.3)
        if touches.any() and speed_mps > MOVING_MPS:
            return OracleResult(speed_mps, seen_s)
        if seen_s is not None and t_s >= seen_s + DEAD_S:
            speed_mps = max(0.0, speed_mps - DECEL_MPS2 * _STEP_S)
        at_m += speed_mps * _STEP_S
        if speed_mps <= 0.0:
            break
    return OracleResult(None, seen_s)


def _sees(bodies: Bodies, x_m: float, y_m: float, yaw_rad: float, sensor_x_m: float, range_m: float) -> bool:
    """Whether a point of the target is visible; points, because parts of a target may be hidden."""
    k = int(np.flatnonzero(bodies.numbers == 1)[0])
    sx, sy = x_m + sensor_x_m * math.cos(yaw_rad), y_m + sensor_x_m * math.sin(yaw_rad)
    pose, size = bodies.poses_map[k], bodies.sizes_m[k]
    away_m = math.hypot(pose[0] - sx, pose[1] - sy)
    reach_m = 0.5 * float(min(size))
    if away_m - reach_m > range_m:
        return False
    share = max(0.0, 1.0 - reach_m / max(away_m, 1e-6))
    points = [(sx + share * (pose[0] - sx), sy + share * (pose[1] - sy), 0.0)]
    if bodies.kinds[k] == VEHICLE:
        points += _corners(pose, size)
    boxes = bodies.boxes()
    if not bodies.people[k]:
        # The box of a cyclist or car does not occlude it.
        boxes = boxes[np.hypot(boxes[:, 0] - pose[0], boxes[:, 1] - pose[1]) > 0.1]
    small, seen = np.full((1, 2), 0.02), np.ones(1)
    return any(
        bool(visible(sx, sy, np.array([point]), small, seen, np.empty((0, 4)), boxes)[0] > 0.0)
        for point in points
    )


def _corners(pose: Array, size: Array) -> list[tuple[float, float, float]]:
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return [
        (float(pose[0] + u * cos - v * sin), float(pose[1] + u * sin + v * cos), 0.0)
        for u in (-0.5 * size[0], 0.5 * size[0])
        for v in (-0.5 * size[1], 0.5 * size[1])
    ]
