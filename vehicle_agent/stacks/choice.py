"""The rooms and the planner for a profile's `stack`.

A stack is imported only when it is selected: importing all of them is most of a process's start time.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from contract.roads.model import RoadMap
from vehicle_agent.config import Profile, ProfileError
from vehicle_agent.localization.worker import LocalizationWorker
from vehicle_agent.onboard.car import Car
from vehicle_agent.signals import PlanAnswer, PlanJob

Planner = Callable[[PlanJob], PlanAnswer]
# Stacks with a motion planner beside the tick.
PLANNING_STACKS = frozenset({"snow_lion"})
# Stacks that can compare scans with a map beside the tick.
LOCALIZING_STACKS = frozenset({"snow_lion"})


def build_car(profile: Profile, road_map: RoadMap, localization_map: str = "") -> Car:
    """The rooms of the profile's stack on one map; control is that of `driving.identification_drive` if set.

    localization_map  version of the map that a worker compares scans with; "": localization needs none
    ProfileError for a stack that this version lacks, for waypoint files that cannot be driven, and for a
    localization map that the stack has no use for.
    """
    if localization_map and profile.stack not in LOCALIZING_STACKS:
        raise ProfileError(f"the {profile.stack} stack does not localize by scans: leave out the point map")
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

            return gem(profile, road_map)
        case "nus":
            from vehicle_agent.stacks.nus import nus

            return nus(profile, road_map)
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


def build_localization_worker(profile: Profile, folder: Path) -> LocalizationWorker:
    """What compares scans with the map in `folder`, for a stack of `LOCALIZING_STACKS`.

    Raises PointMapError for a folder without a sound index.
    """
    from vehicle_agent.stacks.snow_lion import localization_worker

    return localization_worker(profile, folder)
