"""Rooms that several stacks share, built from the profile."""

import math

import msgspec

from contract.roads.model import RoadMap
from vehicle_agent.brake_map import BrakeMap
from vehicle_agent.config import Profile
from vehicle_agent.control.waypoint.brake_gain import BrakeGain
from vehicle_agent.control.waypoint.follower import WaypointFollower
from vehicle_agent.control.waypoint.rear_slip import RearSlip
from vehicle_agent.control.waypoint.steering import BicycleSteering
from vehicle_agent.control.waypoint.steering_trim import SteeringTrim
from vehicle_agent.control.waypoint.twist import TwistController
from vehicle_agent.control.waypoint.waypoint_control import WaypointControl
from vehicle_agent.guard.collision import Avoidance
from vehicle_agent.guard.faults import AgeLimits
from vehicle_agent.guard.guard import Guard
from vehicle_agent.guard.limits import Limits as GuardLimits
from vehicle_agent.hmi.announcer import Announcer
from vehicle_agent.hmi.attention import Attention
from vehicle_agent.hmi.signalling import VehicleSignalling, turns_of
from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.mission.seat_button import StopRules
from vehicle_agent.mission.sections import VehicleExtent
from vehicle_agent.perception.cells import HeightMapPerception
from vehicle_agent.perception.height_map import HeightMap
from vehicle_agent.perception.signs.boards import SignFinder
from vehicle_agent.perception.signs.stages import SignStages
from vehicle_agent.perception.thinned_scans import ScanThinning
from vehicle_agent.perception.tracker import AlphaBetaTracker
from vehicle_agent.perception.tracks import TrackingPerception
from vehicle_agent.planning.waypoint.approach import Approach
from vehicle_agent.planning.waypoint.gap import GapRule
from vehicle_agent.planning.waypoint.obstacle import ObstacleRule
from vehicle_agent.planning.waypoint.waypoint_planning import WaypointPlanning
from vehicle_agent.planning.waypoint.waypoints import WaypointRules
from vehicle_agent.signals.rates import TICK_NS

_TICK_S = TICK_NS * 1e-9
# Lidars and mirrors stand out by so much.
_OWN_M = 0.25
# The guard's decelerations below full braking.
_GUARD_BRAKES_MPS2 = (1.5, 2.5, 3.5, 4.5)


def cells(profile: Profile) -> HeightMapPerception:
    """Obstacle cells for the profile's lidar and body."""
    body = profile.body
    return HeightMapPerception(
        lidar_x_m=profile.lidar.x_m,
        lidar_z_m=profile.lidar.z_m,
        ring_rad_min=profile.lidar.elevation_rad_min,
        body_front_m=body.front_overhang_m,
        body_back_m=body.rear_overhang_m,
        body_half_width_m=0.5 * body.width_m,
    )


def road_users(profile: Profile, rest_memory_ns: int = 4_000_000_000) -> TrackingPerception:
    """Obstacle cells, and tracks of road users: the tracker's or the worker's own.

    rest_memory_ns  how long a cell in the blind zone is kept before a vehicle at rest
    """
    return TrackingPerception(
        msgspec.structs.replace(cells(profile), rest_memory_ns=rest_memory_ns),
        smoothing(profile),
        has_lidar=profile.lidar.rate_hz > 0.0,
    )


def scan_thinning(profile: Profile) -> ScanThinning:
    """Of scans for people who look, without the vehicle's own returns."""
    body = profile.body
    rear_m, front_m, side_m = -body.rear_overhang_m, body.front_overhang_m, 0.5 * body.width_m
    return ScanThinning(own_m=(rear_m - _OWN_M, front_m + _OWN_M, side_m + _OWN_M))


def smoothing(profile: Profile) -> AlphaBetaTracker:
    """Of tracks, in the tick: the worker's own are smoothed already, and more would delay them."""
    if profile.has_tracker:
        return AlphaBetaTracker()
    return AlphaBetaTracker(position_gain=1.0, velocity_gain=1.0)


def sign_finder(profile: Profile) -> SignFinder:
    """The finder of signs for the profile's lidar, for the worker."""
    lidar = profile.lidar
    step_rad = 2.0 * math.pi / max(1, lidar.columns)
    return SignFinder(
        SignStages(x_m=lidar.x_m, z_m=lidar.z_m, intensity_min=lidar.retro_intensity_min, step_ratio=step_rad)
    )


def announcer(profile: Profile, road_map: RoadMap | None = None) -> Announcer:
    """Screens, signals and announcements for the vehicle's outline, as its profile wants them.

    road_map  where it turns off, and where the sun stands; None: it signals no turns, and its lights are on
    """
    body, announcing, signalling = profile.body, profile.announcing, profile.signalling
    origin = None if road_map is None else road_map.origin
    return Announcer(
        Attention(front_m=body.front_overhang_m, half_width_m=0.5 * body.width_m, ahead_m=announcing.ahead_m),
        VehicleSignalling(
            turns={} if road_map is None else turns_of(road_map.lanes),
            kerb=signalling.kerb,
            turn_ahead_m=signalling.turn_ahead_m,
            stop_ahead_m=signalling.stop_ahead_m,
            headlights=signalling.headlights,
            horn=signalling.horn,
            place_deg=None if origin is None else (origin.latitude_deg, origin.longitude_deg),
        ),
        step_aside_ns=round(announcing.step_aside_s * 1e9),
        aside_again_ns=round(announcing.aside_again_s * 1e9),
        courtesy_ns=round(announcing.courtesy_s * 1e9),
        stopping_m=announcing.stopping_m,
    )


def mission_rules(profile: Profile) -> MissionRules:
    """The mission's rules for the vehicle's body and its comfortable deceleration."""
    body = profile.body
    return MissionRules(
        body=VehicleExtent(body.front_overhang_m, body.rear_overhang_m),
        half_width_m=0.5 * body.width_m,
        stops=StopRules(decel_mps2=profile.driving.stop_decel_mps2),
        hold_decel_mps2=profile.driving.stop_decel_mps2,
    )


def waypoint_planning(profile: Profile) -> WaypointPlanning:
    """Waypoint planning within the profile's limits; the obstacle rule by the profile's preset."""
    body, limits, driving = profile.body, profile.limits, profile.driving
    paper = driving.obstacles == "paper"
    return WaypointPlanning(
        waypoints=WaypointRules(limits.speed_mps_max, limits.lateral_accel_mps2_max),
        obstacle=ObstacleRule(
            body_front_m=body.front_overhang_m,
            body_back_m=body.rear_overhang_m,
            body_half_width_m=0.5 * body.width_m,
            wheelbase_m=body.wheelbase_m,
            clearance_m=driving.clearance_m,
            check_m_fixed=15.0 if paper else 0.0,
            along="arc" if paper else "line",
        ),
        gap=GapRule(body.front_overhang_m, body.rear_overhang_m, 0.5 * body.width_m),
        approach=Approach(
            decel_mps2=driving.stop_decel_mps2,
            decel_mps2_firm=limits.decel_mps2_max * 0.45,
            delay_s=profile.response.brake_delay_s,
        ),
    )


def waypoint_control(profile: Profile) -> WaypointControl:
    """Follower and twist controller with the vehicle's identified response."""
    limits, response, driving = profile.limits, profile.response, profile.driving
    return WaypointControl(
        follower=WaypointFollower(
            heading_gain_1ps=driving.heading_gain_1ps,
            heading_integral_1ps2=driving.heading_integral_1ps2,
            dt_s=_TICK_S,
        ),
        steering=BicycleSteering(
            wheelbase_m=profile.body.wheelbase_m,
            steer_rad_max=steer_rad_max(profile),
            steer_rate_radps_max=limits.steer_rate_radps_max,
            dt_s=_TICK_S,
        ),
        twist=TwistController(
            brakes=brake_map(profile),
            accel_mps2_max=limits.accel_mps2_max,
            decel_mps2_max=limits.decel_mps2_max * 0.45,
            accel_filter_s=response.accel_filter_s,
            throttle_feed=response.throttle_per_mps2,
            coast_mps2=response.coast_mps2,
            dt_s=_TICK_S,
        ),
        trim=SteeringTrim(
            wheelbase_m=profile.body.wheelbase_m, initial_rad=response.steer_bias_rad, dt_s=_TICK_S
        ),
        brake_gain=BrakeGain(coast_mps2=response.coast_mps2, dt_s=_TICK_S),
        slip=RearSlip(nominal_per_mps2=rear_slip_per_mps2(profile), dt_s=_TICK_S),
        steer_delay_s=response.steer_delay_s,
        dt_s=_TICK_S,
    )


def guard(profile: Profile) -> Guard:
    """The guard with the profile's limits and the ages of `rates`.

    Without a lidar and without a tracker the GEM stack's expects no percepts.
    """
    perceives = profile.lidar.rate_hz > 0.0 or profile.has_tracker or profile.stack != "gem"
    body, limits = profile.body, profile.limits
    brakes = brake_map(profile)
    return Guard(
        limits=GuardLimits(
            steer_rad_max=steer_rad_max(profile),
            steer_rate_radps_max=limits.steer_rate_radps_max,
            speed_mps_max=limits.speed_mps_max,
        ),
        avoidance=Avoidance(
            wheelbase_m=body.wheelbase_m,
            back_m=body.rear_overhang_m,
            front_m=body.front_overhang_m,
            half_width_m=0.5 * body.width_m,
            brakes=tuple((decel, brakes.brake_ratio(decel)) for decel in _GUARD_BRAKES_MPS2),
            accel_mps2_max=limits.accel_mps2_max,
            delay_s=profile.response.brake_delay_s,
        ),
        stop_ratio=brakes.brake_ratio(0.4 * limits.decel_mps2_max),
        firm_ratio=brakes.brake_ratio(0.85 * limits.decel_mps2_max),
        slow_ratio=brakes.brake_ratio(limits.decel_mps2_comfort),
        ageing=AgeLimits() if perceives else AgeLimits(percept_ns=0),
    )


def height_map(profile: Profile) -> HeightMap:
    """The height map's parameters for the worker; higher returns than the vehicle are ignored."""
    body = profile.body
    return HeightMap(
        above_m=body.height_m + 0.1,
        body_front_m=body.front_overhang_m,
        body_back_m=body.rear_overhang_m,
        body_half_width_m=0.5 * body.width_m,
    )


def rear_slip_per_mps2(profile: Profile) -> float:
    """Slip angle of the rear axle (rad) in a steady turn of 1 m/s2, by the profile's tyres."""
    body, tyres = profile.body, profile.tyres
    return body.mass_kg * tyres.cog_ratio / tyres.cornering_rear_npr


def brake_map(profile: Profile) -> BrakeMap:
    response = profile.response
    return BrakeMap(response.brake_gain, response.brake_offset, response.brake_knee_mps2)


def steer_rad_max(profile: Profile) -> float:
    """Front-wheel angle of the smallest turning circle."""
    return math.atan(profile.body.wheelbase_m / profile.body.turn_radius_m_min)
