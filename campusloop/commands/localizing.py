"""How simulated shuttles know where they are: by GNSS, or by comparing their scans with a point map."""

from enum import StrEnum
from pathlib import Path

from campusloop.shipped import PROFILES
from contract.point_map.map_files import INDEX, PointMapError
from contract.roads.load import load_map
from vehicle_agent.config import ProfileError, load_profile
from vehicle_agent.localization.scan_map.stored_map import checked_index
from vehicle_agent.stacks.choice import LOCALIZING_STACKS

# Where `campusloop workshop survey` puts a campus's point map; they are made, not shipped (decision 27).
POINT_MAPS = Path("var/point-maps")


class Localization(StrEnum):
    """What an operator may choose."""

    GNSS = "gnss"
    SCANS = "scans"


def chosen_profile(localization: Localization, profile: Path | None) -> Path | None:
    """The profile's file: without one given, shuttles that localize by scans are Snow Lions.

    Raises ProfileError for a profile whose stack cannot.
    """
    if localization is Localization.GNSS:
        return profile
    path = profile or PROFILES / "snow-lion.toml"
    stack = load_profile(path).stack
    if stack not in LOCALIZING_STACKS:
        raise ProfileError(
            f"{path} has the {stack} stack, which does not localize by scans: give a profile with "
            f"{' or '.join(sorted(LOCALIZING_STACKS))}, or leave out --localization scans"
        )
    return path


def chosen_point_map(
    localization: Localization, point_map: Path | None, campus_map: Path, *, has_scene: bool
) -> Path | None:
    """The folder of the checked point map; None for GNSS. Raises PointMapError, MapError."""
    if localization is Localization.GNSS:
        if point_map is not None:
            raise PointMapError("--point-map is for --localization scans")
        return None
    if not has_scene:
        raise PointMapError("--localization scans needs --scene: without it lidars see plain walls alone")
    road_map = load_map(campus_map)
    folder = point_map or POINT_MAPS / road_map.campus_id
    if point_map is None and not (folder / INDEX).exists():
        raise PointMapError(
            f"there is no point map in {folder} yet: make one, which takes minutes, with "
            f"`campusloop workshop survey --map {campus_map}`, or give one with --point-map"
        )
    checked_index(folder, road_map.origin)
    return folder.resolve()
