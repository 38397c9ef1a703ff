"""CommonRoad's reactive planner (package commonroad-reactive-planner): the sampling Frenet planner in Python.

It plans the rear axle, and itself tries denser samples while it finds nothing. Runs in the planner's own
environment. One process plans, as in every other driver: its pool of workers is switched off.
"""

import math
from typing import Any

import commonroad_dc.pycrcc as pycrcc
import numpy as np
from commonroad.scenario.lanelet import Lanelet, LaneletNetwork
from commonroad.scenario.scenario import Scenario
from commonroad_clcs.config import CLCSParams, ProcessingOption, ResamplingOption
from commonroad_rp.reactive_planner import ReactivePlanner
from commonroad_rp.state import ReactivePlannerState
from commonroad_rp.utility.config import ReactivePlannerConfiguration
from commonroad_rp.utility.utils_coordinate_system import create_coordinate_system

from benchmarks.peers.messages import PlanRequest, Road

_LIGHT_STEPS = 30
_LIGHT_LEVELS = 2
# Added to all outlines for the tracker's noise. With 0.3 m it stood in crowds without need.
MARGIN_M = 0.15
# Of its three offsets a side, the outer one. Over a whole road at walking speed nearly all of its samples
# bend more sharply than the vehicle can, and it stood at bends with no person near.
ASIDE_M = 1.0
# Of the spline through the path (its default 2.0 moved bends by 0.2 m and made sharper ones at their ends).
_SMOOTHING = 0.5


class Reactive:
    """Settings: `default`, its own horizon (6 s) and four densities of samples; `light`, 3 s and two."""

    package = "commonroad-reactive-planner"

    def __init__(self, setting: str) -> None:
        if setting not in ("default", "light"):
            raise ValueError(f"reactive has no setting {setting!r}; it has: default, light")
        self._setting = setting

    def begin(self, road: Road) -> None:
        config = ReactivePlannerConfiguration()
        config.debug.multiproc = False
        config.debug.logging_level = "ERROR"
        if self._setting == "light":
            config.planning.time_steps_computation = _LIGHT_STEPS
            config.sampling.num_sampling_levels = _LIGHT_LEVELS
        aside_m = min(ASIDE_M, max(0.0, 0.5 * (road.width_m - road.body_width_m)))
        config.sampling.d_min, config.sampling.d_max = -aside_m, aside_m
        vehicle = config.vehicle
        vehicle.length, vehicle.width = road.length_m, road.body_width_m
        # "wb_rear_axle" is from the rear axle to the middle of the body: the outline is laid about that.
        vehicle.wb_rear_axle = 0.5 * road.length_m - road.rear_overhang_m
        vehicle.wb_front_axle = road.wheelbase_m - vehicle.wb_rear_axle
        vehicle.a_max = road.decel_mps2_max
        vehicle.delta_max = math.atan(road.wheelbase_m * road.curvature_1pm_max)
        vehicle.delta_min = -vehicle.delta_max
        vehicle.v_delta_max, vehicle.v_delta_min = road.steer_rate_radps_max, -road.steer_rate_radps_max
        vehicle._update_computed_params()
        config.update(scenario=_scenario(road))
        planner = self._planner = ReactivePlanner(config)
        self._system = create_coordinate_system(np.array(road.path), _reference())
        planner.set_reference_path(coordinate_system=self._system)
        self._speed_mps, self._wheelbase_m = road.speed_mps_max, road.wheelbase_m
        self._steps = config.planning.time_steps_computation
        self._dt_s = config.planning.dt
        self._next: tuple[Any, Any] | None = None

    def prepare(self, request: PlanRequest) -> None:
        state = ReactivePlannerState(
            time_step=0,
            position=np.array([request.x_m, request.y_m]),
            orientation=request.yaw_rad,
            velocity=request.v_mps,
            acceleration=request.a_mps2,
            steering_angle=math.atan(self._wheelbase_m * request.curvature_1pm),
            yaw_rate=request.v_mps * request.curvature_1pm,
        )
        # Followed exactly, the last plan's next state is where the vehicle is: its own loop goes on so, too.
        # But at rest: its standing plan repeats the acceleration that it stopped with, and starts no more.
        planner, curvilinear = self._planner, self._next if request.v_mps > 0.0 else None
        planner._low_vel_mode = request.v_mps < planner.config.planning.low_vel_mode_threshold
        planner.reset(
            initial_state_cart=state,
            initial_state_curv=curvilinear,
            collision_checker=self._checker(request),
            coordinate_system=self._system,
        )
        # The speed now is passed for the sake of its interval, which is then set to all that is allowed.
        planner.set_desired_velocity(self._speed_mps, current_speed=max(request.v_mps, 1e-3))
        planner.set_v_sampling_parameters(0.0, self._speed_mps)

    def _checker(self, request: PlanRequest) -> Any:
        checker = pycrcc.CollisionChecker()
        for _, x, y, yaw, vx, vy, length, width, is_person in request.others:
            moving = pycrcc.TimeVariantCollisionObject(0)
            for k in range(self._steps + 1):
                at_x, at_y = x + k * self._dt_s * vx, y + k * self._dt_s * vy
                if is_person:
                    moving.append_obstacle(pycrcc.Circle(0.5 * length + MARGIN_M, at_x, at_y))
                else:
                    box = pycrcc.RectOBB(0.5 * length + MARGIN_M, 0.5 * width + MARGIN_M, yaw, at_x, at_y)
                    moving.append_obstacle(box)
            checker.add_collision_object(moving)
        return checker

    def plan(self) -> Any:
        self._next = None
        return self._planner.plan()

    def rows(self, found: Any) -> tuple[list[tuple[float, ...]], str]:
        if found is None:
            return [], "no_plan"
        trajectory, along, across = found
        self._next = (along[1], across[1])
        rows = []
        for k, state in enumerate(trajectory.state_list):
            curvature = math.tan(state.steering_angle) / self._wheelbase_m
            x, y = state.position
            rows.append(
                (k * self._dt_s, x, y, state.orientation, state.velocity, state.acceleration, curvature)
            )
        return rows, ""


def _reference() -> CLCSParams:
    """The planner's own preparation of its reference, but for the smoothing."""
    params = CLCSParams(processing_option=ProcessingOption.SPLINE_SMOOTHING)
    params.spline.degree_spline, params.spline.smoothing_factor = 3, _SMOOTHING
    params.resampling.option = ResamplingOption.ADAPTIVE
    params.resampling.min_step, params.resampling.max_step = 0.5, 1.0
    return params


def _scenario(road: Road) -> Scenario:
    """One lanelet, the road: the planner asks for a scenario to begin with."""
    path = np.array(road.path)
    steps = np.gradient(path, axis=0)
    normal = np.column_stack((-steps[:, 1], steps[:, 0])) / np.hypot(steps[:, 0], steps[:, 1])[:, None]
    left, right = path + 0.5 * road.width_m * normal, path - 0.5 * road.width_m * normal
    scenario = Scenario(0.1)
    scenario.add_objects(LaneletNetwork.create_from_lanelet_list([Lanelet(left, path, right, 1)]))
    return scenario
