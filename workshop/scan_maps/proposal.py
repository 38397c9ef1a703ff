"""The page of this room: parcels of scans and the map in force, to a proposed map and what it changes."""

import shutil
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
from scipy.spatial import cKDTree

from contract.localization_maps import LocalizationMapError
from contract.point_map.map_files import PointMapIndex, read_index, read_tile
from contract.point_map.tiles import Surfels, TileError, no_surfels
from contract.scan_parcels.proposals import COMPARISON, PICTURE, Comparison, ProposedTile
from workshop.cloud_mapping.map_folder import TILE_M
from workshop.cloud_mapping.mapping import CloudMappingParams, MappingProgress
from workshop.scan_maps.alignment import Alignment, AlignmentParams, aligned, ground_heights, laid
from workshop.scan_maps.comparison import ComparisonParams, TileChange, changes_of, tile_changes
from workshop.scan_maps.drives import NoMapOfScans, ScanMap, map_parcels
from workshop.scan_maps.merging import write_proposed_tiles
from workshop.scan_maps.picture import write_picture

# The scans reach farther than the tiles they were taken in.
_MARGIN_M = 40.0
# Two maps of one place that differ by more are of different frames, or one of them is wrong.
ALIGNED_M_MAX = 3.0
# With fewer elements in one place two maps have only their edges in common.
_COMMON_MIN = 2_000


class ProposalParams(msgspec.Struct, frozen=True):
    mapping: CloudMappingParams = CloudMappingParams()
    alignment: AlignmentParams = AlignmentParams()
    comparison: ComparisonParams = ComparisonParams()


def propose(
    parcels: Sequence[Path], in_force: Path | None, out: Path, work: Path, params: ProposalParams,
    progress: MappingProgress,
) -> Comparison:  # fmt: skip
    """Writes the proposed map, `comparison.json` and a picture into a new folder `out`.

    in_force: the folder of the map in force, None without one. work: a folder that may be removed afterwards.
    Raises NoMapOfScans, LocalizationMapError for a map in force that is damaged, OSError.
    """
    index = None if in_force is None else read_index(in_force)
    if index is not None and (index.frame != "map" or index.origin is None):
        raise NoMapOfScans("The map in force lies in no map frame: it cannot be compared.")
    whole = no_surfels() if index is None or in_force is None else _all_of(in_force, index)
    ground = ground_heights(whole) if len(whole) else None
    found = map_parcels(parcels, work, params.mapping, progress, ground)
    origin = found.cloud_map.origin
    assert origin is not None, "every drive was placed by fixes"
    if index is not None and index.origin != origin:
        raise NoMapOfScans("The scans are of another map frame than the map in force: the origins differ.")
    new, poses = found.cloud_map.surfels, found.cloud_map.keyframe_poses
    progress.begin("comparison", 4)
    old = _near(whole, new, TILE_M if index is None else index.tile_m)
    progress.advance(1)
    alignment = None
    if len(old):
        alignment = _on_old(new, old, params)
    if alignment is not None:
        new, poses = laid(new, alignment.T), alignment.T @ poses
    changes = changes_of(new, old, found.clouds, poses, params.mapping.surfaces, params.comparison)
    tile_m = TILE_M if index is None else index.tile_m
    tiles = tile_changes(new, old, changes, tile_m, params.comparison)
    progress.advance(1)
    try:
        voxel_m = params.mapping.surfaces.voxel_m
        written, remade = write_proposed_tiles(
            out, in_force, index, new, old, changes, tiles, (tile_m, voxel_m, origin)
        )
        progress.advance(1)
        said = _comparison(found, index, written, alignment, tiles, set(remade))
        (out / COMPARISON).write_bytes(msgspec.json.format(msgspec.json.encode(said), indent=1) + b"\n")
        write_picture(out / PICTURE, new, old, changes, tiles, tile_m, poses)
    except TileError as error:
        shutil.rmtree(out, ignore_errors=True)
        raise NoMapOfScans(f"The scans make no map: {error}") from error
    except (OSError, LocalizationMapError):
        shutil.rmtree(out, ignore_errors=True)
        raise
    progress.advance(1)
    return said


def _on_old(new: Surfels, old: Surfels, params: ProposalParams) -> Alignment | None:
    """None: the scans are of another place than the map in force, and lie where their fixes are."""
    found = aligned(new, old, params.alignment)
    if found is None and _beside(new, old, params) < _COMMON_MIN:
        return None
    if found is None:
        raise NoMapOfScans("The scans and the map in force have too few surfaces in common to be compared.")
    moved_m = float(np.hypot(*((found.T @ [*new.means.mean(axis=0), 1.0])[:2] - new.means.mean(axis=0)[:2])))
    if moved_m > ALIGNED_M_MAX:
        raise NoMapOfScans(
            f"The scans lie {moved_m:.1f} m beside the map in force: their fixes are not usable."
        )
    return found


def _beside(new: Surfels, old: Surfels, params: ProposalParams) -> int:
    """How many new elements have an old one near by, seen from above."""
    apart_m, _ = cKDTree(old.means[:, :2]).query(
        new.means[:, :2], distance_upper_bound=params.comparison.near_m
    )
    return int(np.isfinite(apart_m).sum())


def _all_of(folder: Path, index: PointMapIndex) -> Surfels:
    """Raises LocalizationMapError."""
    parts = [read_tile(folder, entry) for entry in index.tiles] or [no_surfels()]
    return Surfels(
        np.concatenate([part.means for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.std_m for part in parts]),
        np.concatenate([part.seen for part in parts]),
    )


def _near(old: Surfels, new: Surfels, tile_m: float) -> Surfels:
    """The old elements of the tiles around the new ones."""
    low = np.floor((new.means[:, :2].min(axis=0) - _MARGIN_M) / tile_m) * tile_m
    high = np.ceil((new.means[:, :2].max(axis=0) + _MARGIN_M) / tile_m) * tile_m
    return old.selected(((old.means[:, :2] >= low) & (old.means[:, :2] < high)).all(axis=1))


def _comparison(
    found: ScanMap, index: PointMapIndex | None, written: PointMapIndex, alignment: Alignment | None,
    tiles: Sequence[TileChange], remade: set[tuple[int, int]],
) -> Comparison:  # fmt: skip
    apart: tuple[str, ...] = ()
    if alignment is None and index is not None:
        apart = (
            "Nothing in common with the map in force: it lies where its fixes are, at heights of its own.",
        )
    compared = [tile for tile in tiles if not tile.is_added]
    changed = sum(tile.new + tile.moved + tile.gone for tile in compared)
    known = changed + sum(tile.same for tile in compared)
    numbers = found.cloud_map.residuals
    moved = None if alignment is None else alignment.T
    middle = np.array([*found.cloud_map.surfels.means.mean(axis=0), 1.0])
    shift = np.zeros(3) if moved is None else (moved @ middle - middle)[:3]
    return Comparison(
        map_version=written.map_version,
        in_force_version="" if index is None else index.map_version,
        drives=len(found.drives),
        scans=numbers.scans,
        way_m=round(numbers.way_m, 1),
        fix_median_m=round(numbers.fix_median_m, 4),
        moving_removed=numbers.surfels_moved,
        shift_m=(round(float(shift[0]), 4), round(float(shift[1]), 4), round(float(shift[2]), 4)),
        turn_rad=0.0 if moved is None else round(float(np.arctan2(moved[1, 0], moved[0, 0])), 6),
        residual_median_m=None if alignment is None else round(alignment.residual_median_m, 4),
        residual_p95_m=None if alignment is None else round(alignment.residual_p95_m, 4),
        changed_ratio=None if alignment is None else round(changed / max(1, known), 4),
        tiles=tuple(
            ProposedTile(**msgspec.structs.asdict(tile), is_remade=(tile.ix, tile.iy) in remade)
            for tile in tiles
        ),
        tiles_of_map=len(written.tiles),
        bytes_of_map=sum(tile.bytes for tile in written.tiles),
        notes=(*found.notes, *found.cloud_map.notes, *apart),
    )
