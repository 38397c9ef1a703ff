"""The Snow Lion stack: behaviour, Gaussian-process path, speed profile and MPC."""

from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from vehicle_agent.can.by_wire import codec_of
from vehicle_agent.config import Limits, Profile
from vehicle_agent.mission.mission import Mission
from vehicle_agent.onboard.car import Car
from vehicle_agent.planning.behaviour.crossing_traffic import CrossingRules
from vehicle_agent.planning.behaviour.decide import BehaviourRules
from vehicle_agent.planning.motion.motion_planning import MotionPlanning
from vehicle_agent.planning.motion.request import ClearanceLaw, DrivingLimits, MotionParams, Vehicle
from vehicle_agent.planning.worker import MotionPlanner
from vehicle_agent.stacks.rooms import announcer, guard, mission_rules, road_users
from vehicle_agent.stacks.scan_map import localization
from vehicle_agent.stacks.snow_lion_control import control
from vehicle_agent.world.observed import ObservedWorld
from vehicle_agent.world.surroundings import Surroundings
from vehicle_agent.world.view import VisibilityParams

# Share of the steering rate that a plan may use: a path must not bend faster than the wheels turn.
_STEER_SHARE = 0.85
# A step of the ground this near beside the body on its line is a bump or a lowered kerb, and no edge.
_KERB_KEEP_M = 0.2


def snow_lion(profile: Profile, road_map: RoadMap, *, by_scans: bool = False) -> Car:
    """The rooms of the Snow Lion paper's vehicle, on one map.

    by_scans  a worker compares the lidar's scans with a map of surfaces; otherwise GNSS/INS alone
    """
    body, network = profile.body, RoadNetwork(road_map)
    half_m = 0.5 * body.width_m
    has_lidar = profile.lidar.rate_hz > 0.0
    return Car(
        can=codec_of(profile),
        localization=localization(profile, road_map, by_scans=by_scans),
        perception=road_users(profile),
        world=ObservedWorld(
            network,
            Surroundings(body.front_overhang_m, body.rear_overhang_m, half_m),
            VisibilityParams(profile.lidar.x_m),
            walls_from_map=not has_lidar,
        ),
        mission=Mission(network, mission_rules(profile)),
        planning=MotionPlanning(
            network,
            profile.limits.speed_mps_max,
            body.wheelbase_m,
            kerb_keep_m=half_m + _KERB_KEEP_M,
        ),
        control=control(profile),
        guard=guard(profile),
        hmi=announcer(profile, road_map),
    )


def planner(profile: Profile) -> MotionPlanner:
    """The motion planner that answers the plan jobs of this stack."""
    return MotionPlanner(behaviour_rules(profile), motion_params(profile))


def behaviour_rules(profile: Profile) -> BehaviourRules:
    """The behavioral planner's parameters."""
    body = profile.body
    return BehaviourRules(
        front_m=body.front_overhang_m,
        back_m=body.rear_overhang_m,
        half_width_m=0.5 * body.width_m,
        crossing=CrossingRules(body.front_overhang_m),
        sensor_x_m=profile.lidar.x_m,
    )


def motion_params(profile: Profile) -> MotionParams:
    """The motion planner's parameters."""
    body, limits = profile.body, profile.limits
    vehicle = Vehicle(
        length_m=body.length_m,
        width_m=body.width_m,
        rear_overhang_m=body.rear_overhang_m,
        wheelbase_m=body.wheelbase_m,
        curvature_1pm_max=1.0 / body.turn_radius_m_min,
        curvature_rate_1pmps_max=_STEER_SHARE * limits.steer_rate_radps_max / body.wheelbase_m,
    )
    driving = DrivingLimits(
        speed_mps_max=limits.speed_mps_max,
        accel_mps2_max=limits.accel_mps2_max,
        accel_fade_1ps=_accel_fade_1ps(limits),
        decel_mps2_comfort=limits.decel_mps2_comfort,
        jerk_mps3_max=profile.driving.jerk_mps3_max,
        lateral_accel_mps2_max=limits.lateral_accel_mps2_max,
        hard_decel_mps2=0.9 * limits.decel_mps2_max,
    )
    return MotionParams(vehicle=vehicle, limits=driving, law=ClearanceLaw(speed_mps_max=limits.speed_mps_max))


def _accel_fade_1ps(limits: Limits) -> float:
    if limits.accel_mps2_top is None:
        return 0.0
    return (limits.accel_mps2_max - limits.accel_mps2_top) / limits.speed_mps_max
