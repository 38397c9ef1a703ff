"""How simulated shuttles know where they are: by GNSS, or by comparing their scans with a point map."""

from enum import StrEnum
from pathlib import Path

from campusloop.shipped import PROFILES, occupancy_map_of
from contract.localization_maps import LocalizationMapError
from contract.point_map.map_files import INDEX
from contract.roads.load import load_map
from vehicle_agent.config import load_profile
from vehicle_agent.stacks.choice import check_localizes_by_scans, checked_localization_map

# Where `campusloop workshop survey` puts a campus's point map; they are made, not shipped (decision 27).
POINT_MAPS = Path("var/point-maps")


class Localization(StrEnum):
    """What an operator may choose."""

    GNSS = "gnss"
    SCANS = "scans"


def chosen_profile(localization: Localization, profile: Path | None) -> Path | None:
    """The profile's file: without one given, shuttles that localize by scans are Snow Lions.

    Raises ProfileError for a vehicle without the sensor for it.
    """
    if localization is Localization.GNSS:
        return profile
    path = profile or PROFILES / "snow-lion.toml"
    check_localizes_by_scans(load_profile(path))
    return path


def chosen_point_map(
    localization: Localization,
    point_map: Path | None,
    campus_map: Path,
    *,
    has_scene: bool,
    profile: Path | None = None,
) -> Path | None:
    """The folder of the checked map of the kind that the profile's stack needs; None for GNSS.

    profile  as `chosen_profile` gives it. Raises LocalizationMapError, MapError."""
    if localization is Localization.GNSS:
        if point_map is not None:
            raise LocalizationMapError("--point-map is for --localization scans")
        return None
    if not has_scene:
        raise LocalizationMapError(
            "--localization scans needs --scene: without it lidars see plain walls alone"
        )
    chosen, road_map = load_profile(profile or PROFILES / "snow-lion.toml"), load_map(campus_map)
    if chosen.stack == "nus":
        folder, command = point_map or occupancy_map_of(campus_map), "survey-laser"
    else:
        folder, command = point_map or POINT_MAPS / road_map.campus_id, "survey"
    if point_map is None and (folder is None or not (folder / INDEX).exists()):
        where = "" if folder is None else f" in {folder}"
        raise LocalizationMapError(
            f"there is no map for the {chosen.stack} stack{where} yet: make one, which takes minutes, with "
            f"`campusloop workshop {command} --map {campus_map}`, or give one with --point-map"
        )
    assert folder is not None, "without a folder it was refused"
    checked_localization_map(chosen, folder, road_map.origin)
    return folder.resolve()
