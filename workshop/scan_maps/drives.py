"""Parcels of scans to drives, each dead-reckoned and laid on its fixes, and all joined in one graph."""

from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec
import numpy as np

from contract.geometry import Array
from contract.roads.model import Origin
from contract.scan_parcels.parcels import FIXES, SCANS, ParcelError, ParcelHeader, read_header, unpack
from workshop.cloud_mapping.drive_scans import DriveScans
from workshop.cloud_mapping.gnss_fixes import FixFileError, laid_on, read_fixes
from workshop.cloud_mapping.ground import ground_of
from workshop.cloud_mapping.keyframes import Reckoned
from workshop.cloud_mapping.mapping import (
    CloudMap,
    CloudMappingParams,
    Drive,
    MappingProgress,
    TooFewScans,
    cloud_map_of,
    places_on,
    reckoned_drive,
    solved_on,
)
from workshop.cloud_mapping.pose_graph import Place
from workshop.clouds.recordings import find_recordings

# From the fixes, before loops: dead reckoning drifts by a hundredth of the way. More is no drift.
RECKONED_M_MIN, RECKONED_RATIO_MAX = 1.0, 0.03


# Of another map's ground below the rear axle: kerbs, speed bumps and both maps' noise.
GROUND_STD_M = 0.15

# Heights (n,) of the ground at places (n, 2), NaN where it is not known.
GroundHeights = Callable[[Array], Array]


class NoMapOfScans(Exception):
    """The parcels make no map; the message is one sentence."""


class PlacedDrive(msgspec.Struct, frozen=True):
    """A drive on its fixes. places: of its keyframes, counted from its first."""

    name: str
    reckoned: Reckoned
    places: tuple[Place, ...]


class ScanMap(msgspec.Struct, frozen=True):
    """The map of all drives; clouds: of its keyframes, base frame; notes: what was left out, and why."""

    cloud_map: CloudMap
    clouds: tuple[np.ndarray, ...]
    drives: tuple[str, ...]
    notes: tuple[str, ...]


class _DriveFolder(msgspec.Struct, frozen=True):
    name: str
    folder: Path
    scans: int


def map_parcels(
    parcels: Sequence[Path], work: Path, params: CloudMappingParams, progress: MappingProgress,
    ground: GroundHeights | None = None,
) -> ScanMap:  # fmt: skip
    """One map of all drives whose scans are in the parcels. work: a folder for what is unpacked.

    ground: of another map, whose heights the drives take where they drive over it

    A parcel or drive that cannot be used is left out, and is named in `notes`. Raises NoMapOfScans, OSError.
    """
    notes: list[str] = []
    origin, folders = _unpacked(parcels, work, notes)
    drives: list[PlacedDrive] = []
    for one in folders:
        placed = _placed(one, origin, params, progress, notes, ground)
        if placed is not None:
            drives.append(placed)
    if not drives:
        raise NoMapOfScans(f"No drive makes a map: {' '.join(notes) or 'there is none.'}")
    joined, places, starts = _joined(drives)
    progress.begin("ground", 1)
    drive = Drive(joined, ground_of(joined.clouds, params.ground))
    progress.advance(1)
    solution = solved_on(drive, places, starts, params, progress)
    found = cloud_map_of(drive, solution, origin, params, progress)
    if not len(found.surfels):
        raise NoMapOfScans("No surface was seen from two places.")
    return ScanMap(found, tuple(joined.clouds), tuple(one.name for one in drives), tuple(notes))


def _unpacked(
    parcels: Sequence[Path], work: Path, notes: list[str]
) -> tuple[Origin, tuple[_DriveFolder, ...]]:
    """The frame of all parcels, and a folder for each drive."""
    headers: list[tuple[ParcelHeader, Path]] = []
    for path in parcels:
        try:
            headers.append((read_header(path), path))
        except ParcelError as error:
            notes.append(f"{path.name} was left out: {error}")
    if not headers:
        raise NoMapOfScans(f"There is no parcel of scans. {' '.join(notes)}".strip())
    headers.sort(key=lambda one: (one[0].vehicle_id, one[0].first_ns, one[0].drive_id, one[0].number))
    origins = {header.origin for header, _ in headers}
    if len(origins) > 1:
        raise NoMapOfScans("The parcels are of map frames with different origins.")
    scans: dict[str, int] = {}
    for header, path in headers:
        name = f"{header.vehicle_id}-{header.drive_id}"
        try:
            unpack(path, work / name)
        except ParcelError as error:
            notes.append(f"{path.name} was left out: {error}")
            continue
        scans[name] = scans.get(name, 0) + header.scans
    found = tuple(_DriveFolder(name, work / name, count) for name, count in sorted(scans.items()))
    return origins.pop(), found


def _placed(
    one: _DriveFolder, origin: Origin, params: CloudMappingParams, progress: MappingProgress,
    notes: list[str], ground: GroundHeights | None,
) -> PlacedDrive | None:  # fmt: skip
    if one.scans < 2:
        notes.append(f"Drive {one.name} was left out: it has one scan.")
        return None
    try:
        fixes = read_fixes(one.folder / FIXES, origin)
        scans = DriveScans(find_recordings(one.folder / SCANS))
        reckoned = reckoned_drive(scans, one.scans, params, progress).reckoned
    except (FixFileError, TooFewScans) as error:
        notes.append(f"Drive {one.name} was left out: {error}")
        return None
    places = places_on(reckoned, fixes, params)
    if not places:
        notes.append(f"Drive {one.name} was left out: fewer than two fixes are good enough to place it.")
        return None
    reckoned.poses = list(laid_on(np.array(reckoned.poses), places))
    apart_m = [float(np.hypot(*(reckoned.poses[p.node][:3, 3] - p.place_map)[:2])) for p in places]
    way_m = float(np.linalg.norm(np.diff(np.array(reckoned.poses)[:, :3, 3], axis=0), axis=1).sum())
    if float(np.median(apart_m)) > max(RECKONED_M_MIN, RECKONED_RATIO_MAX * way_m):
        notes.append(
            f"Drive {one.name} was left out: its scans and its fixes differ by {np.median(apart_m):.1f} m. "
            "The scans are too far apart, or the fixes are wrong."
        )
        return None
    if ground is not None:
        places = _on_ground(reckoned, places, ground)
    return PlacedDrive(one.name, reckoned, tuple(places))


def _on_ground(reckoned: Reckoned, places: list[Place], ground: GroundHeights) -> list[Place]:
    """The places with the ground's height where it is known; the drive is raised to it first.

    Fixes have no heights, and dead reckoning drifts in them: two maps would differ by more than by a change.
    """
    heights_m = ground(np.array([place.place_map[:2] for place in places]))
    known = np.isfinite(heights_m)
    if not known.any():
        return places
    own_m = np.array([reckoned.poses[place.node][2, 3] for place in places])
    raised_m = float(np.median(heights_m[known] - own_m[known]))
    lift = np.eye(4)
    lift[2, 3] = raised_m
    reckoned.poses = [lift @ pose for pose in reckoned.poses]
    return [
        place if not known[number] else msgspec.structs.replace(
            place,
            place_map=np.array([*place.place_map[:2], heights_m[number]]),
            std_m=np.array([*place.std_m[:2], GROUND_STD_M]),
        )
        for number, place in enumerate(places)
    ]  # fmt: skip


def _joined(drives: Sequence[PlacedDrive]) -> tuple[Reckoned, list[Place], list[int]]:
    """(all scans and keyframes one after the other, the fixes of all, the first keyframe of each drive)."""
    whole, places, starts = Reckoned(), [], []
    for drive in drives:
        first, scans, one = len(whole.poses), len(whole.stamps_ns), drive.reckoned
        starts.append(first)
        places += [msgspec.structs.replace(place, node=place.node + first) for place in drive.places]
        whole.stamps_ns += one.stamps_ns
        whole.keyframe_of += [number + first for number in one.keyframe_of]
        whole.relatives += one.relatives
        whole.poses += one.poses
        whole.keyframes += [number + scans for number in one.keyframes]
        whole.clouds += one.clouds
        whole.scans_empty += one.scans_empty
        whole.scans_poor += one.scans_poor
        whole.stamps_back += one.stamps_back
    return whole, places, starts
