"""The rooms and the planner for a profile's `stack`.

A stack is imported only when it is selected: importing all of them is most of a process's start time.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from contract.localization_manifest import LocalizationMapKind
from contract.occupancy.tile_files import OccupancyTilesIndex
from contract.point_map.map_files import PointMapIndex
from contract.roads.model import Origin, RoadMap
from vehicle_agent.config import Profile, ProfileError
from vehicle_agent.localization.planar_map import stored_map as planar_map
from vehicle_agent.localization.scan_map import stored_map
from vehicle_agent.localization.worker import LocalizationWorker
from vehicle_agent.onboard.car import Car
from vehicle_agent.perception.worker import CellsWorker, PerceptionWorker
from vehicle_agent.signals import PlanAnswer, PlanJob
from vehicle_agent.stacks.rooms import height_map, scan_thinning, sign_finder

Planner = Callable[[PlanJob], PlanAnswer]
# Stacks with a motion planner beside the tick.
PLANNING_STACKS = frozenset({"snow_lion"})
# Stacks that read signs in scans.
SIGN_READING_STACKS = frozenset({"gem"})


def build_car(profile: Profile, road_map: RoadMap, localization_map: str = "") -> Car:
    """The rooms of the profile's stack on one map; control is that of `driving.identification_drive` if set.

    localization_map  version of the map that a worker compares scans with, or `NO_LOCALIZATION_MAP`;
                      "": localization needs none
    ProfileError for a stack that this version lacks, for waypoint files that cannot be driven, and for a
    localization map that the vehicle has no scans for.
    """
    if localization_map:
        check_localizes_by_scans(profile)
    car = _stack_car(profile, road_map, localization_map)
    if not profile.driving.identification_drive:
        return car
    from vehicle_agent.stacks.identification import excitation_control

    return replace(car, control=excitation_control(profile))


def _stack_car(profile: Profile, road_map: RoadMap, localization_map: str) -> Car:
    if profile.driving.waypoint_files and profile.stack != "gem":
        raise ProfileError(f"[driving] waypoint_files: only the gem stack drives them, not {profile.stack}")
    match profile.stack:
        case "gem":
            from vehicle_agent.stacks.gem import gem

            return gem(profile, road_map, by_scans=bool(localization_map))
        case "nus":
            from vehicle_agent.stacks.nus import nus

            return nus(profile, road_map, by_scans=bool(localization_map))
        case "snow_lion":
            from vehicle_agent.stacks.snow_lion import snow_lion

            return snow_lion(profile, road_map, by_scans=bool(localization_map))
        case _:
            raise ProfileError(f"this version has no stack {profile.stack!r}; it has: gem, nus, snow_lion")


def build_planner(profile: Profile, road_map: RoadMap) -> Planner | None:
    """The motion planner of the profile's stack; None for a stack that plans within the tick.

    Pure: equal jobs give equal answers, in any process and order.
    """
    if profile.stack != "snow_lion":
        return None
    from vehicle_agent.stacks.snow_lion import planner

    return planner(profile)


def worker_tracks(profile: Profile) -> bool:
    """The perception worker of this vehicle tracks road users, for which it needs the vehicle's motion."""
    return not profile.has_tracker


def build_perception_worker(profile: Profile) -> PerceptionWorker:
    """What makes percepts of the vehicle's scans, beside the tick. Raises DetectorFileError."""
    finder = sign_finder(profile) if profile.stack in SIGN_READING_STACKS else None
    if not worker_tracks(profile):
        return CellsWorker(height_map(profile), finder, scan_thinning(profile))
    from vehicle_agent.stacks.own_perception import tracks_worker

    return tracks_worker(profile, finder)


def perception_lacks(profile: Profile) -> str:
    """What the vehicle's own perception does without here, as a sentence for an operator; "": nothing."""
    if not worker_tracks(profile):
        return ""
    from vehicle_agent.stacks.own_perception import lacking

    return lacking(profile)


def build_localization_worker(profile: Profile, folder: Path) -> LocalizationWorker:
    """What compares scans with the map in `folder`.

    Raises LocalizationMapError for a folder without a sound index, and ProfileError.
    """
    check_localizes_by_scans(profile)
    if profile.stack == "nus":
        from vehicle_agent.stacks import nus

        return nus.localization_worker(profile, folder)
    from vehicle_agent.stacks import scan_map

    return scan_map.localization_worker(profile, folder)


def checked_localization_map(
    profile: Profile, folder: Path, origin: Origin
) -> PointMapIndex | OccupancyTilesIndex:
    """The index of the stack's kind of map, whose every tile is whole and lies in the road map's frame.

    Raises LocalizationMapError: damaged, of another kind, or of another place.
    """
    return (
        planar_map.checked_index(folder, origin)
        if profile.stack == "nus"
        else stored_map.checked_index(folder, origin)
    )


def localization_kind(stack: str) -> LocalizationMapKind:
    """The kind of map that a stack compares scans with."""
    return "occupancy" if stack == "nus" else "points"


def check_localizes_by_scans(profile: Profile) -> None:
    """Raises ProfileError for a vehicle without the sensor whose scans its stack compares with a map."""
    is_planar = profile.stack == "nus"
    sensor = profile.planar_scanner if is_planar else profile.lidar
    if sensor.rate_hz <= 0.0:
        name = "[planar_scanner]" if is_planar else "[lidar]"
        raise ProfileError(
            f"{profile.name} has no {name} whose scans could be compared with a map: give a profile with "
            "one, or let it drive by GNSS/INS, without a map of scans"
        )


def warm_localization(profile: Profile) -> None:
    """Calls every kernel of the stack's localization worker once."""
    if profile.stack == "nus":
        from vehicle_agent.localization.planar_map.warm import warm_planar_map

        warm_planar_map()
    else:
        from vehicle_agent.localization.scan_map.warm import warm_scan_map

        warm_scan_map()
