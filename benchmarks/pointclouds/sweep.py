"""One annotated sweep: which boxes the cells and objects find, and which cells are flagged."""

from dataclasses import dataclass

import numpy as np

from benchmarks.pointclouds.annotations import Annotations
from contract.geometry import Array, BoolArray
from vehicle_agent.perception.height_map import HeightMap, percept_from_scan
from vehicle_agent.perception.points.cells import percept_of, point_heights
from vehicle_agent.perception.points.clusters import ClusterParams, objects_of_points
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.perception.points.level import above_plane, ground_plane
from vehicle_agent.signals import PEDESTRIAN

REACH_M = 42.0
# An object's middle may be this far outside the box that is drawn around it.
_MIDDLE_M = 0.3
# A box has the ground at its lower side: returns there are not the person's.
_FEET_M = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class SweepResult:
    """What one sweep shows.

    By box (n,): ranges_m, kinds, returns in it above its feet; as_obstacle: an obstacle cell or an object's
    middle is in it; as_pedestrian, by_height_map
    By cell with returns (k,): cell_ranges_m, flagged, flagged_by_height_map, in_box
    """

    ranges_m: Array
    kinds: np.ndarray
    returns: np.ndarray
    as_obstacle: BoolArray
    as_pedestrian: BoolArray
    by_height_map: BoolArray
    cell_ranges_m: Array
    flagged: BoolArray
    flagged_by_height_map: BoolArray
    in_box: BoolArray


def grid_around(own_m: float, above_m: float) -> PointGrid:
    """Cells all around a sensor whose vehicle reaches own_m from it."""
    return PointGrid(
        above_m, own_m, own_m, own_m, reach_front_m=REACH_M, reach_back_m=REACH_M, reach_side_m=REACH_M,
        body_margin_m=0.0, body_trail_m=0.0,
    )  # fmt: skip


def judged(points_sensor: np.ndarray, boxes: Annotations, grid: PointGrid) -> SweepResult:
    """The result of one sweep; points and boxes in the sensor's frame, z up. Raises NoGroundError."""
    plane = ground_plane(points_sensor)
    points = above_plane(points_sensor, plane)
    heights = point_heights(points, grid)
    cells = percept_of(heights, 1, grid).cells_base
    seen = objects_of_points(points, heights, 1, grid, ClusterParams(viewpoint_x_m=0.0))
    peer = HeightMap(
        grid.above_m, grid.body_front_m, grid.body_back_m, grid.body_half_width_m, reach_front_m=REACH_M,
        reach_back_m=REACH_M, reach_side_m=REACH_M, body_margin_m=0.0,
    )  # fmt: skip
    peer_cells = percept_from_scan(points, 1, peer).cells_base
    people = seen.poses_base[seen.kinds == PEDESTRIAN, :2]
    n = len(boxes)
    returns = np.zeros(n, np.int64)
    as_obstacle, as_pedestrian, by_height_map = (np.zeros(n, np.bool_) for _ in range(3))
    half_cell_m = 0.5 * grid.cell_m
    for k in range(n):
        centre, size, yaw = boxes.centres[k], boxes.sizes_m[k], boxes.yaws[k]
        inside = within(points_sensor[:, :2], centre, size, yaw, 0.0)
        z = points_sensor[:, 2] - (centre[2] - 0.5 * size[2])
        returns[k] = np.count_nonzero(inside & (z > _FEET_M) & (z < size[2]))
        as_obstacle[k] = (
            within(cells, centre, size, yaw, half_cell_m).any()
            or within(seen.poses_base[:, :2], centre, size, yaw, 0.0).any()
        )
        as_pedestrian[k] = within(people, centre, size, yaw, _MIDDLE_M).any()
        by_height_map[k] = within(peer_cells, centre, size, yaw, half_cell_m).any()
    used = _middles(np.unique(heights.cell_of[heights.cell_of >= 0]), heights.top_m.shape[1], grid)
    in_box = np.zeros(len(used), np.bool_)
    for k in range(n):
        in_box |= within(used, boxes.centres[k], boxes.sizes_m[k], boxes.yaws[k], half_cell_m)
    return SweepResult(
        np.hypot(boxes.centres[:, 0], boxes.centres[:, 1]),
        boxes.kinds,
        returns,
        as_obstacle,
        as_pedestrian,
        by_height_map,
        np.hypot(used[:, 0], used[:, 1]),
        _is_in(used, cells, grid),
        _is_in(used, peer_cells, grid),
        in_box,
    )


def within(places: Array, centre: Array, size: Array, yaw: float, margin_m: float) -> BoolArray:
    """(n,) whether places (n, 2) are in a box, margin_m wider on each side."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    dx, dy = places[:, 0] - centre[0], places[:, 1] - centre[1]
    inside: BoolArray = (np.abs(cos * dx + sin * dy) <= 0.5 * size[0] + margin_m) & (
        np.abs(-sin * dx + cos * dy) <= 0.5 * size[1] + margin_m
    )
    return inside


def _middles(numbers: np.ndarray, columns: int, grid: PointGrid) -> Array:
    rows, across = numbers // columns, numbers % columns
    middles: Array = np.column_stack(
        ((rows + 0.5) * grid.cell_m - grid.reach_back_m, (across + 0.5) * grid.cell_m - grid.reach_side_m)
    )
    return middles


def _is_in(used: Array, cells: Array, grid: PointGrid) -> BoolArray:
    """(k,) which of the used cells are among `cells`."""
    keys = [
        np.rint((places + REACH_M) / grid.cell_m - 0.5).astype(np.int64) @ np.array([100_000, 1])
        for places in (used, cells)
    ]
    found: BoolArray = np.isin(*keys)
    return found
