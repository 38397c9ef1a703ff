"""The GEM stack: the implementation of each room, with the profile's parameters."""

from pathlib import Path

import msgspec

from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from vehicle_agent.can.by_wire import codec_of
from vehicle_agent.config import Profile, ProfileError
from vehicle_agent.mission.mission import Mission
from vehicle_agent.onboard.car import Car
from vehicle_agent.perception.signs.reading import SignReadingPerception
from vehicle_agent.planning.waypoint.recorded import RecordedWay
from vehicle_agent.planning.waypoint.signs import SignRule
from vehicle_agent.stacks.rooms import (
    announcer,
    guard,
    mission_rules,
    road_users,
    waypoint_control,
    waypoint_planning,
)
from vehicle_agent.stacks.scan_map import localization
from vehicle_agent.waypoints.files import WaypointFileError
from vehicle_agent.waypoints.recorded_way import recorded_way
from vehicle_agent.world.surroundings import Surroundings

# Who stands before a vehicle at rest below the beams is known by the cells if they had no track before.
_REST_MEMORY_NS = 60_000_000_000


def gem(profile: Profile, road_map: RoadMap, *, by_scans: bool = False) -> Car:
    """The rooms of the GEM paper's vehicle, on one map.

    by_scans  a worker compares the lidar's scans with a map of surfaces; otherwise GNSS/INS alone, as in the
              paper
    """
    body = profile.body
    return Car(
        can=codec_of(profile),
        localization=localization(profile, road_map, by_scans=by_scans),
        perception=SignReadingPerception(road_users(profile, _REST_MEMORY_NS)),
        world=Surroundings(body.front_overhang_m, body.rear_overhang_m, 0.5 * body.width_m),
        mission=Mission(RoadNetwork(road_map), mission_rules(profile)),
        planning=msgspec.structs.replace(
            waypoint_planning(profile),
            recorded=recorded_waypoints(profile, road_map),
            signs=SignRule(body.front_overhang_m, side=profile.signalling.kerb),
        ),
        control=waypoint_control(profile),
        guard=guard(profile),
        hmi=announcer(profile, road_map),
    )


def recorded_waypoints(profile: Profile, road_map: RoadMap) -> RecordedWay | None:
    """The recorded way that the profile names; None if it names none. Raises ProfileError."""
    files = profile.driving.waypoint_files
    if not files:
        return None
    try:
        return recorded_way(Path(files), road_map, waypoint_planning(profile).waypoints)
    except WaypointFileError as error:
        raise ProfileError(f"[driving] waypoint_files: {error}") from error
