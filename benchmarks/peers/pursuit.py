"""Pure pursuit (Coulter 1992), without a planner: the path at the cap, the rest is the rule for people."""

import math
import time

import numpy as np

from benchmarks.peers.messages import Plan, PlanRequest, Road
from contract.geometry import Array, Pose2, arc_lengths, curvatures, pose_at, project
from vehicle_agent.control.waypoint.follower import FollowerState
from vehicle_agent.control.waypoint.pure_pursuit import PurePursuit

# The NUS paper's look-ahead, grown with speed as it must be above the paper's 2 m/s.
_LOOK_AHEAD_M, _LOOK_AHEAD_S = 3.0, 1.0
_STEP_S, _STEPS = 0.02, 15
_LOOK_M, _ASIDE_M, _BEFORE_M = 15.0, 0.3, 1.5
_AT = 0.25


class Pursuit:
    """`blind` ignores people. Otherwise it brakes comfortably to stand 1.5 m before a road user within 0.3 m
    of the body's path over the next 15 m, and as hard as it can if that is too late."""

    def __init__(self, blind: bool, steps: int = _STEPS) -> None:
        """steps: of a plan, 0.02 s each"""
        self._blind, self._steps = blind, steps

    def begin(self, road: Road) -> None:
        self._road = road
        self._path: Array = np.array(road.path)
        self._s = arc_lengths(self._path)
        bends = np.maximum(np.abs(curvatures(self._path)), 1e-6)
        self._caps_mps = np.minimum(road.speed_mps_max, np.sqrt(road.lateral_accel_mps2_max / bends))

    def plan(self, request: PlanRequest) -> Plan:
        """The next moments of a bicycle that follows commands without delay."""
        begun_cpu, begun_wall = time.process_time_ns(), time.perf_counter_ns()
        road, target_mps, hard = self._road, *self._target_speed(request)
        accel = road.accel_mps2_max if target_mps > request.v_mps else -road.accel_mps2_max
        if hard:
            accel = -road.decel_mps2_max
        x, y, yaw, v = request.x_m, request.y_m, request.yaw_rad, request.v_mps
        curvature = request.curvature_1pm
        rows = [(0.0, x, y, yaw, v, accel, curvature)]
        rate = road.steer_rate_radps_max / road.wheelbase_m
        for k in range(1, self._steps + 1):
            wanted = self._curvature(Pose2(x, y, yaw), v)
            curvature += min(max(wanted - curvature, -rate * _STEP_S), rate * _STEP_S)
            before = v
            v = max(0.0, v + accel * _STEP_S)
            v = min(v, max(target_mps, before)) if accel > 0.0 else (v if hard else max(v, target_mps))
            way = 0.5 * (before + v) * _STEP_S
            yaw += curvature * way
            x, y = x + way * math.cos(yaw), y + way * math.sin(yaw)
            rows.append((k * _STEP_S, x, y, yaw, v, (v - before) / _STEP_S, curvature))
        cpu_ms = 1e-6 * (time.process_time_ns() - begun_cpu)
        return Plan(rows, "", cpu_ms, 1e-6 * (time.perf_counter_ns() - begun_wall), 0.0)

    def _curvature(self, pose: Pose2, v: float) -> float:
        _, _, segment = project(self._path, self._s, pose.x_m, pose.y_m, 0, len(self._path))
        rule = PurePursuit(max(_LOOK_AHEAD_M, _LOOK_AHEAD_S * v))
        turn, _, _ = rule.step(FollowerState(), pose, 1.0, self._path[segment + 1 :])
        limit = self._road.curvature_1pm_max
        return min(max(turn, -limit), limit)

    def _target_speed(self, request: PlanRequest) -> tuple[float, bool]:
        """(target speed, whether to brake as hard as possible)."""
        road = self._road
        s_m, _, segment = project(self._path, self._s, request.x_m, request.y_m, 0, len(self._path))
        comfort = road.accel_mps2_max
        ahead = slice(segment, segment + 30)
        slows = np.sqrt(self._caps_mps[ahead] ** 2 + 2.0 * comfort * np.maximum(self._s[ahead] - s_m, 0.0))
        target_mps = float(slows.min())
        if self._blind:
            return target_mps, False
        free_m = self._free_m(request, s_m)
        stop_m = free_m - _BEFORE_M
        needed = request.v_mps**2 / (2.0 * max(stop_m, 1e-3))
        hard = stop_m <= 0.0 or needed > 1.5 * comfort
        return min(target_mps, math.sqrt(2.0 * comfort * max(stop_m, 0.0))), hard

    def _free_m(self, request: PlanRequest, s_m: float) -> float:
        """Distance of the bumper to the nearest outline in the swept path, up to 15 m."""
        road = self._road
        front_m = road.length_m - road.rear_overhang_m
        places = np.array([(other[1], other[2]) for other in request.others]).reshape(-1, 2)
        radii = np.array([_radius_m(*other[6:9]) for other in request.others])
        if not len(places):
            return _LOOK_M
        for way_m in np.arange(0.0, _LOOK_M, _AT):
            x, y, yaw = pose_at(self._path, self._s, s_m + front_m + way_m)
            dx, dy = places[:, 0] - x, places[:, 1] - y
            along = np.cos(yaw) * dx + np.sin(yaw) * dy
            aside = np.abs(-np.sin(yaw) * dx + np.cos(yaw) * dy)
            reach = 0.5 * road.body_width_m + _ASIDE_M + radii
            if bool(np.any((aside < reach) & (along > -radii) & (along < radii + _AT))):
                return float(way_m)
        return _LOOK_M


def _radius_m(length_m: float, width_m: float, is_person: float) -> float:
    """Of the disc about an outline."""
    return 0.5 * length_m if is_person else 0.5 * math.hypot(length_m, width_m)
