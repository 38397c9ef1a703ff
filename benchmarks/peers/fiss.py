"""FISS+ (Sun et al., IROS 2023) of the package fiss-planner, a Frenet planner in C++, by its `LocalPlanner`.

It plans the middle of the body: its reference is where the middle goes when the rear axle keeps to the path.
Runs in the planner's own environment.
"""

import math
from typing import Any

import fiss_planner as fp
import numpy as np

from benchmarks.peers.messages import PlanRequest, Road

HORIZON_S = 6.0
_STEP_S = 0.1
_TURNS_FROM_MPS = 0.3


class Fiss:
    """Settings: `default` as shipped; `crowd`, its distances set for people instead of cars; `fop`, the
    classical search of every candidate (Werling et al., ICRA 2010), otherwise as `crowd`."""

    package = "fiss-planner"

    def __init__(self, setting: str) -> None:
        if setting not in ("default", "crowd", "fop"):
            raise ValueError(f"fiss has no setting {setting!r}; it has: default, crowd, fop")
        self._setting = setting

    def begin(self, road: Road) -> None:
        vehicle = fp.VehicleParams()
        vehicle.length, vehicle.width = road.length_m, road.body_width_m
        vehicle.wheelbase = road.wheelbase_m
        self._ahead_m = 0.5 * road.length_m - road.rear_overhang_m
        vehicle.rear_axle_to_center = self._ahead_m
        vehicle.max_speed = max(road.speed_mps_max, 0.1) + 0.5
        vehicle.max_accel, vehicle.max_decel = road.accel_mps2_max, road.decel_mps2_max
        vehicle.max_lat_accel = road.lateral_accel_mps2_max
        vehicle.max_steer = math.atan(road.wheelbase_m * road.curvature_1pm_max)
        vehicle.max_steer_rate = road.steer_rate_radps_max
        self._planner = fp.LocalPlanner(self._config(road), vehicle)
        path = np.array(road.path)
        steps = np.gradient(path, axis=0)
        heading = steps / np.hypot(steps[:, 0], steps[:, 1])[:, None]
        middle = path + self._ahead_m * heading
        self._planner.set_reference_path(middle[:, 0].tolist(), middle[:, 1].tolist())
        self._speed_mps, self._kappa_max = road.speed_mps_max, road.curvature_1pm_max

    def _config(self, road: Road) -> Any:
        config = fp.LocalPlannerConfig()
        config.desired_speed = road.speed_mps_max
        config.path.lane_width = road.width_m
        config.path.num_left_lanes = config.path.num_right_lanes = 0
        if self._setting == "default":
            return config
        planner = config.planner
        if self._setting == "fop":
            planner.type = fp.PlannerType.FOP
        crowd(planner)
        return config

    def prepare(self, request: PlanRequest) -> None:
        cos, sin = math.cos(request.yaw_rad), math.sin(request.yaw_rad)
        x_m, y_m = request.x_m + self._ahead_m * cos, request.y_m + self._ahead_m * sin
        self._t_s = request.t_s
        self._ego = fp.EgoState(
            x_m, y_m, request.yaw_rad, request.v_mps, request.a_mps2, request.curvature_1pm
        )
        self._others = []
        for number, x, y, yaw, vx, vy, length, width, _ in request.others:
            v = math.hypot(vx, vy)
            course = math.atan2(vy, vx) if v > 0.0 else yaw
            self._others.append(
                fp.predict_constant_velocity(int(number), x, y, course, v, length, width, HORIZON_S, _STEP_S)
            )

    def plan(self) -> Any:
        return self._planner.step(self._t_s, self._ego, self._others, self._speed_mps)

    def rows(self, found: Any) -> tuple[list[tuple[float, ...]], str]:
        """With the planner's own fail-safes (the rest of the last plan, a shorter horizon, then braking)."""
        states = ("emergency", "fallback", "degraded")
        words = next((word for word in states if getattr(found, word)), "" if found.success else "no_plan")
        plan = found.trajectory
        t, x, y, yaw, v, a, kappa = (
            np.asarray(c) for c in (plan.t, plan.x, plan.y, plan.yaw, plan.v, plan.a, plan.kappa)
        )
        if len(t) < 2:
            return [], words
        yaw, kappa = self._held(yaw, v), np.clip(kappa, -self._kappa_max, self._kappa_max)
        x, y = x - self._ahead_m * np.cos(yaw), y - self._ahead_m * np.sin(yaw)
        return list(zip(t - t[0], x, y, yaw, v, a, kappa, strict=True)), words

    def _held(self, yaw: Any, v: Any) -> Any:
        """The headings, but below 0.3 m/s the one before: there its lateral polynomial, a function of time,
        turns on the spot, which no vehicle can follow."""
        out, last = np.array(yaw), self._ego.yaw
        for k in range(len(out)):
            last = out[k] = out[k] if v[k] >= _TURNS_FROM_MPS else last
        return out


def crowd(planner: Any) -> None:
    """Of five settings on random crowds 901 to 905, the one that drove farthest without a contact.

    Its safety envelope of headway and time to collision is for car traffic: people violate it all the time,
    and the planner then makes an emergency stop. Margins and costs of clearance remain.
    """
    planner.safety.enabled = False
    planner.sampling.min_t, planner.sampling.max_t = 2.0, 4.0
    planner.cost.desired_gap = 1.5
    planner.cost.desired_clearance = 0.7
