"""The NUS stack: the implementation of each room, with the profile's parameters."""

from pathlib import Path

import msgspec

from contract.geometry import Pose2
from contract.occupancy.tile_files import read_index
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from vehicle_agent.config import Profile, ProfileError
from vehicle_agent.control.waypoint.pure_pursuit import PurePursuit
from vehicle_agent.control.waypoint.waypoint_control import WaypointControl
from vehicle_agent.localization.gnss_ins import GnssInsLocalization
from vehicle_agent.localization.planar_map.field_window import OccupancyTiles
from vehicle_agent.localization.planar_map.matcher import PlanarMatcher
from vehicle_agent.localization.planar_map.stored_map import stored_tiles
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization
from vehicle_agent.localization.worker import LocalizationWorker
from vehicle_agent.onboard.car import Car
from vehicle_agent.planning.cost_map.cost_map_planning import CostMapPlanning
from vehicle_agent.planning.cost_map.crossings import CrossingRule
from vehicle_agent.planning.cost_map.safe_speeds import SafeSpeeds
from vehicle_agent.planning.waypoint.approach import Approach
from vehicle_agent.planning.waypoint.gap import GapRule
from vehicle_agent.planning.waypoint.waypoints import WaypointRules
from vehicle_agent.stacks.gem import gem
from vehicle_agent.stacks.rooms import rear_slip_per_mps2, road_users, waypoint_control

# The look-ahead of 3 m is sufficient up to this speed.
SPEED_MPS_MAX = 2.0


def nus(profile: Profile, road_map: RoadMap, *, by_scans: bool = False) -> Car:
    """The rooms of the NUS paper's vehicle, on one map; what the paper leaves open is the GEM stack's.

    Laser and camera track people: the guard uses their velocities, the cost map their positions.
    by_scans  a worker compares the planar scanner's scans with an occupancy map; otherwise GNSS/INS alone
    """
    base = gem(profile, road_map)
    return Car(
        can=base.can,
        localization=planar_localization(profile, road_map) if by_scans else base.localization,
        perception=road_users(profile),
        world=base.world,
        mission=base.mission,
        planning=planning(profile, road_map),
        control=pursuit_control(profile),
        guard=base.guard,
        hmi=base.hmi,
    )


def planar_localization(profile: Profile, road_map: RoadMap) -> ScanMapLocalization:
    """GNSS, gyroscope and wheels in one filter, and where the scans of a planar laser lie on a map.

    Its agreement counts what hides the walls little, so that doubt may grow slowly (docs/vehicle/laser.md).
    """
    return ScanMapLocalization(
        GnssInsLocalization(road_map.origin, slip_s2pm=rear_slip_per_mps2(profile)),
        map_std_m=0.03,
        map_std_rad=0.003,
        map_m=10.0,
        lacking_power=2.0,
        agreement_ratio=0.65,
        agreement_min=0.35,
        agreement_max=0.5,
        doubt_weight=0.8,
        doubt_max=1.5,
        starts_alone=True,
    )


def localization_worker(profile: Profile, folder: Path) -> LocalizationWorker:
    """What compares the planar scanner's scans with the occupancy map in a folder.

    Raises OccupancyTilesError, and ProfileError for a vehicle without a planar scanner.
    """
    return LocalizationWorker(planar_matcher(profile, stored_tiles(folder, read_index(folder))))


def planar_matcher(profile: Profile, tiles: OccupancyTiles, seed: int = 1) -> PlanarMatcher:
    """For the profile's planar scanner. Raises ProfileError for a vehicle without one."""
    scanner = profile.planar_scanner
    if scanner.rate_hz <= 0.0:
        raise ProfileError(f"{profile.name} has no [planar_scanner] whose scans an occupancy map could place")
    return PlanarMatcher(tiles, Pose2(scanner.x_m, scanner.y_m, scanner.yaw_rad), scanner.step_rad, seed)


def planning(
    profile: Profile, road_map: RoadMap, crossings: CrossingRule = CrossingRule()
) -> CostMapPlanning:
    """Cost-map planning within the profile's limits."""
    body, limits, driving = profile.body, profile.limits, profile.driving
    speed_mps = min(limits.speed_mps_max, SPEED_MPS_MAX)
    return CostMapPlanning(
        network=RoadNetwork(road_map),
        body_front_m=body.front_overhang_m,
        body_back_m=body.rear_overhang_m,
        half_width_m=0.5 * body.width_m,
        wheelbase_m=body.wheelbase_m,
        eye_m=profile.lidar.x_m,
        gap=GapRule(body.front_overhang_m, body.rear_overhang_m, 0.5 * body.width_m),
        waypoints=WaypointRules(speed_mps, limits.lateral_accel_mps2_max),
        speeds=SafeSpeeds(speed_mps),
        crossings=crossings,
        approach=Approach(
            decel_mps2=driving.stop_decel_mps2,
            decel_mps2_firm=limits.decel_mps2_max * 0.45,
            delay_s=profile.response.brake_delay_s,
        ),
    )


def pursuit_control(profile: Profile) -> WaypointControl:
    """Pure pursuit with the vehicle's identified response."""
    return msgspec.structs.replace(waypoint_control(profile), follower=PurePursuit())
