"""How simulated shuttles know where they are: by GNSS, or by comparing their scans with a point map."""

from enum import StrEnum
from pathlib import Path

from campusloop.shipped import PROFILES, occupancy_map_of, point_map_of
from contract.localization_maps import LocalizationMapError
from contract.roads.load import load_map
from vehicle_agent.config import ProfileError, load_profile
from vehicle_agent.stacks.choice import LOCALIZING_STACKS, checked_localization_map


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
    localization: Localization,
    profile: Path | None,
    point_map: Path | None,
    campus_map: Path,
    *,
    has_scene: bool,
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
    assert profile is not None, "localization by scans has a profile"
    chosen = load_profile(profile)
    shipped = occupancy_map_of(campus_map) if chosen.stack == "nus" else point_map_of(campus_map)
    folder = point_map or shipped
    if folder is None:
        raise LocalizationMapError(
            f"no point map ships with {campus_map}: make one with `campusloop workshop "
            f"{'survey-laser' if chosen.stack == 'nus' else 'survey'}`, "
            "and give it with --point-map"
        )
    checked_localization_map(chosen, folder, load_map(campus_map).origin)
    return folder.resolve()
