"""Objects of one scan: connected returns above the ground, their boxes and kinds."""

import math
from typing import NamedTuple

import numpy as np

from contract.geometry import Array
from vehicle_agent.perception.points.boxes import (
    ABOVE_CHEST,
    B_TALL,
    B_TOP,
    BX,
    BY,
    LENGTH,
    RETURNS,
    WIDTH,
    YAW,
    object_boxes,
)
from vehicle_agent.perception.points.cells import PointHeights
from vehicle_agent.perception.points.components import connected, split_people
from vehicle_agent.perception.points.fine_cells import FINE, FineCells, fine_cells
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.perception.points.kinds import KindGates, best_kinds, kind_scores
from vehicle_agent.signals import PEDESTRIAN, VEHICLE
from vehicle_agent.signals.objects import SeenObjects


class ClusterParams(NamedTuple):
    """Of which objects are looked for.

    gates            sizes of the kinds
    points_min       returns of an object
    length_m_max     longer things are walls and hedges: they are cells, not objects
    group_m_max      longest group of people that is taken apart
    viewpoint_x_m    of the lidars, ahead of the rear axle: visible sides face it
    person_half_m    middle of a person behind the visible side
    person_m         a person's diameter, from and to
    pair_m_max       longest pair of people, or of a person and a post or trunk
    group_score      a group is people if their mean score is at least this
    fitted_score, fitted_m  a car whose length and width are seen, and that looks like one, has a fitted box
    """

    gates: KindGates = KindGates()
    points_min: int = 3
    length_m_max: float = 10.0
    group_m_max: float = 5.0
    viewpoint_x_m: float = 1.3
    person_half_m: float = 0.08
    person_m: tuple[float, float] = (0.45, 0.7)
    pair_m_max: float = 2.6
    group_score: float = 0.35
    fitted_score: float = 0.9
    fitted_m: tuple[float, float] = (3.2, 1.3)


def objects_of_points(
    points: np.ndarray, heights: PointHeights, stamp_ns: int, grid: PointGrid, params: ClusterParams
) -> SeenObjects:
    """The objects of one scan; points (n, 3) float32, base frame, of which `heights` was made."""
    cells = fine_cells(points, heights, grid)
    boxes, scores = _boxes_and_scores(cells, grid, params)
    kept = (boxes[:, RETURNS] >= params.points_min) & (boxes[:, LENGTH] <= params.length_m_max)
    boxes, scores = boxes[kept], scores[kept]
    kinds, best = best_kinds(scores)
    poses: Array = boxes[:, [BX, BY, YAW]].copy()
    sizes: Array = boxes[:, [LENGTH, WIDTH, B_TOP]].copy()
    _complete_people(poses, sizes, kinds == PEDESTRIAN, params)
    fitted = (kinds == VEHICLE) & (best >= params.fitted_score)
    fitted &= (sizes[:, 0] >= params.fitted_m[0]) & (sizes[:, 1] >= params.fitted_m[1])
    # A face as wide as a car and no deeper is its front or rear.
    across = (kinds == VEHICLE) & (sizes[:, 0] < 2.1)
    poses[across, 2] += 0.5 * math.pi
    sizes[across, :2] = sizes[across, 1::-1]
    velocities = np.full((len(kinds), 2), math.nan)
    return SeenObjects(stamp_ns, kinds, best, poses, sizes, velocities, fitted)


def _boxes_and_scores(cells: FineCells, grid: PointGrid, params: ClusterParams) -> tuple[Array, Array]:
    """Boxes and scores of all objects; a group is taken apart where its parts look like people."""
    cell_m = grid.cell_m / FINE
    labels = connected(cells.places, cells.number_at, cells.values)
    count = int(labels.max(initial=-1)) + 1
    boxes = object_boxes(cells.values, labels, count, cell_m)
    scores = kind_scores(boxes, params.gates)
    is_group = _may_be_group(boxes, scores, params)
    if not is_group.any():
        return boxes, scores
    split = split_people(cells.places, cells.number_at, cells.values, labels, is_group)
    parts = int(split.max()) + 1
    part_boxes = object_boxes(cells.values, split, parts, cell_m)
    part_scores = kind_scores(part_boxes, params.gates)
    whole_of = np.zeros(parts, np.int64)
    whole_of[split] = labels
    returns = part_boxes[:, RETURNS]
    total = np.bincount(whole_of, returns * part_scores[:, PEDESTRIAN], count)
    mean = total / np.maximum(np.bincount(whole_of, returns, count), 1.0)
    # No car is as short as two people side by side.
    no_car = (boxes[:, LENGTH] < params.pair_m_max) | (mean > scores[:, VEHICLE])
    taken_apart = is_group & (mean >= params.group_score) & no_car
    chosen = taken_apart[whole_of]
    return (
        np.vstack((boxes[~taken_apart], part_boxes[chosen])),
        np.vstack((scores[~taken_apart], part_scores[chosen])),
    )


def _may_be_group(boxes: Array, scores: Array, params: ClusterParams) -> np.ndarray:
    """(objects,) bool: as high as people, and wider than one."""
    gates = params.gates
    wide: np.ndarray = (
        (boxes[:, LENGTH] > 0.75)
        & (boxes[:, LENGTH] <= params.group_m_max)
        & (boxes[:, B_TOP] >= gates.person_top_m[0] - 0.5 * gates.person_soft_m)
        & ((boxes[:, B_TALL] <= gates.tall_m + 0.15) | (boxes[:, LENGTH] <= params.pair_m_max))
        & ((scores[:, VEHICLE] < 0.9) | (boxes[:, LENGTH] <= params.pair_m_max))
        & (boxes[:, ABOVE_CHEST] >= 6.0)
    )
    return wide


def _complete_people(poses: Array, sizes: Array, people: np.ndarray, params: ClusterParams) -> None:
    """Moves people's middles behind the side that is seen, and makes them discs."""
    dx, dy = poses[people, 0] - params.viewpoint_x_m, poses[people, 1]
    apart = np.maximum(np.hypot(dx, dy), 1e-6)
    poses[people, 0] += params.person_half_m * dx / apart
    poses[people, 1] += params.person_half_m * dy / apart
    diameter = np.clip(sizes[people, :2].mean(axis=1), *params.person_m)
    sizes[people, 0] = sizes[people, 1] = diameter
