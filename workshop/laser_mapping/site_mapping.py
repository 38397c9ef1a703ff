"""From a laser log and a receiver's fixes to the occupancy tiles of a whole site, in the campus's map frame.

Fixes put the drive where it was, so that no loop has to be searched: what was passed twice lies near itself,
and is matched there. The fixes stay in the graph, since a map that agrees with itself can still be bent.
"""

import msgspec
import numpy as np

from contract.geometry import Array
from contract.occupancy.occupancy_map import UNKNOWN, Cells, OccupancyMap
from vehicle_agent.localization.laser.dead_reckoning import DeadReckoningParams
from vehicle_agent.localization.laser.surfaces import SurfaceParams
from workshop.carmen.laser_logs import LaserLog
from workshop.cloud_mapping.gnss_fixes import Fixes, FixParams
from workshop.laser_mapping.keyframes import dead_reckoned, scan_poses
from workshop.laser_mapping.mapping import MappingProgress
from workshop.laser_mapping.occupancy import OccupancyParams, occupancy_map
from workshop.laser_mapping.placement import node_places, placed_poses, way_m
from workshop.laser_mapping.refinement import RefinementParams, refined
from workshop.laser_mapping.residuals import pass_deviations

Tiles = dict[tuple[int, int], Cells]


class SiteMappingParams(msgspec.Struct, frozen=True):
    """The parameters of the stages, for a vehicle outdoors whose wheels and gyroscope are good.

    tile_m   edge of a tile; region_tiles: tiles along the edge of what is drawn at once
    """

    tile_m: float = 32.0
    region_tiles: int = 8
    dead_reckoning: DeadReckoningParams = DeadReckoningParams(
        surface=SurfaceParams(range_m_max=30.0, spacing_m=0.1),
        keyframe_m=1.0,
        keyframe_rad=0.2,
        keyframes_max=10,
        odometry_m=0.004,
        odometry_rad=0.0015,
        odometry_ratio=0.02,
        slip_rad_per_m=0.001,
    )
    fixes: FixParams = FixParams()
    refinement: RefinementParams = RefinementParams()
    occupancy: OccupancyParams = OccupancyParams(cell_m=0.1, range_m_max=30.0, step_m=0.2)


class SiteResiduals(msgspec.Struct, frozen=True):
    """fixes_median_m, fixes_p95_m: how far the map lies from the fixes it used; passes: pairs matched."""

    scans: int
    way_m: float
    fixes: int
    fixes_median_m: float
    fixes_p95_m: float
    passes: int
    pass_median_m: float
    pass_p95_m: float
    tiles: int


class SiteMap(msgspec.Struct, frozen=True):
    """tiles: cells by tile; poses (n, 3) of the laser at every scan, map frame."""

    tiles: Tiles
    poses: Array
    residuals: SiteResiduals


def map_site(log: LaserLog, fixes: Fixes, params: SiteMappingParams, progress: MappingProgress) -> SiteMap:
    """The tiles of a drive. The fixes are of the vehicle's base. Raises NotPlaced, MapTooLarge."""
    progress.begin("dead reckoning", len(log))
    reckoned = dead_reckoned(log, params.dead_reckoning, progress.advance)
    keyframes = reckoned.keyframes
    mount = log.T_base_laser
    cos, sin = np.cos(mount.yaw_rad), np.sin(mount.yaw_rad)
    lever = -np.array([cos * mount.x_m + sin * mount.y_m, cos * mount.y_m - sin * mount.x_m])
    places = node_places(keyframes, log.stamps_s, fixes, lever, params.fixes)
    first = placed_poses(keyframes, places, keyframes.edges, params.refinement.graph)
    progress.begin("refinement", len(keyframes) * len(params.refinement.matches))
    last = refined(keyframes, first.poses, (), params.refinement, progress.advance, places)
    poses = scan_poses(reckoned, last.graph.poses)
    progress.begin("occupancy", len(log))
    tiles = occupancy_tiles(log, poses, params, progress)
    off = np.sqrt(last.graph.chi2)
    of_places = off[len(last.edges) :] * np.array([place.std_m for place in places])
    passes = [edge for edge in last.edges if edge.is_loop]
    apart, _ = pass_deviations(last.graph.poses, passes)
    return SiteMap(
        tiles,
        poses,
        SiteResiduals(
            len(log), float(way_m(poses)[-1]), len(places), _percentile(of_places, 50.0),
            _percentile(of_places, 95.0), len(passes), _percentile(apart, 50.0), _percentile(apart, 95.0),
            len(tiles),
        ),
    )  # fmt: skip


def occupancy_tiles(
    log: LaserLog, poses: Array, params: SiteMappingParams, progress: MappingProgress
) -> Tiles:
    """The tiles that the log's beams reach, drawn by regions, so that a site of any size fits memory."""
    region_m = params.region_tiles * params.tile_m
    reach_m = params.occupancy.range_m_max
    tiles: Tiles = {}
    low = np.floor((poses[:, :2].min(axis=0) - reach_m) / region_m).astype(np.int64)
    high = np.floor((poses[:, :2].max(axis=0) + reach_m) / region_m).astype(np.int64)
    for column in range(int(low[0]), int(high[0]) + 1):
        for row in range(int(low[1]), int(high[1]) + 1):
            corner = region_m * np.array([column, row])
            away = np.maximum(corner - poses[:, :2], poses[:, :2] - corner - region_m).max(axis=1)
            near = away <= reach_m
            progress.advance(int(((away < 0.0) & near).sum()))
            if near.any():
                part = msgspec.structs.replace(
                    log, ranges_m=log.ranges_m[near], stamps_s=log.stamps_s[near], odometry=log.odometry[near]
                )
                drawn = occupancy_map(part, poses[near], params.occupancy, _no_advance)
                tiles |= _cut(drawn, (column, row), params)
    return tiles


def _cut(drawn: OccupancyMap, region: tuple[int, int], params: SiteMappingParams) -> Tiles:
    """The region's tiles of which something is known."""
    side = round(params.tile_m / params.occupancy.cell_m)
    first_column = round(drawn.origin_x_m / drawn.cell_m)
    first_row = round(drawn.origin_y_m / drawn.cell_m)
    rows, columns = drawn.cells.shape
    tiles: Tiles = {}
    for number in range(params.region_tiles**2):
        ix = region[0] * params.region_tiles + number % params.region_tiles
        iy = region[1] * params.region_tiles + number // params.region_tiles
        cells: Cells = np.full((side, side), UNKNOWN, dtype=np.uint8)
        x, y = ix * side - first_column, iy * side - first_row
        left, right = max(0, x), min(columns, x + side)
        bottom, top = max(0, y), min(rows, y + side)
        if left < right and bottom < top:
            cells[bottom - y : top - y, left - x : right - x] = drawn.cells[bottom:top, left:right]
            if (cells != UNKNOWN).any():
                tiles[ix, iy] = cells
    return tiles


def _no_advance(steps: int) -> None:
    """A region's scans were told already."""


def _percentile(values: Array, share: float) -> float:
    return float(np.percentile(values, share)) if len(values) else 0.0
