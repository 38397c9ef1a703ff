"""Batches for training: labeled scans, turned, mirrored, thinned and brightened at random."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle_agent.perception.pillars.grid import PillarGrid, pillars_of
from workshop.detector.labeled_scans import LabeledScan
from workshop.detector.targets import Targets, targets_of

# Pillars along x and y of the window that a step looks at, and how far from the vehicle it may lie.
_WINDOW = (160, 128)
_REACH_M = 44.0
_ROAD_USER_RATIO = 0.85

Array32 = NDArray[np.float32]


class Batch(NamedTuple):
    """features (p, points_max, FEATURES), cells (p,) over all scans' squares, targets stacked (b, ...)."""

    features: Array32
    cells: NDArray[np.int64]
    targets: Targets


def batch_of(scans: Sequence[LabeledScan], grid: PillarGrid, rng: np.random.Generator | None = None) -> Batch:
    """One batch. rng changes the scans at random and takes a window of each; without it they stay whole."""
    features, cells, targets = [], [], []
    for number, plain in enumerate(scans):
        scan, part = plain, grid
        if rng is not None:
            scan = varied(plain, rng)
            part = window(scan, grid, rng)
        pillars = pillars_of(scan.points, scan.is_older, part, rng)
        features.append(pillars.features)
        cells.append(pillars.cells + number * 2 * part.nx * part.ny)
        targets.append(targets_of(scan.kinds, scan.boxes, scan.hits, part))
    stacked = Targets(*(np.stack(arrays) for arrays in zip(*targets, strict=True)))
    return Batch(np.concatenate(features), np.concatenate(cells), stacked)


def window(scan: LabeledScan, grid: PillarGrid, rng: np.random.Generator) -> PillarGrid:
    """A part of the ground, mostly with a road user in it: most of a scan is empty, and costs as much."""
    reach_m = np.array([_WINDOW[0], _WINDOW[1]]) * grid.cell_m
    middle = rng.uniform(-_REACH_M, _REACH_M, 2)
    if len(scan.boxes) and rng.random() < _ROAD_USER_RATIO:
        middle = _some_road_user(scan, rng) + rng.uniform(-0.35, 0.35, 2) * reach_m
    low = np.clip(middle - 0.5 * reach_m, -_REACH_M, _REACH_M - reach_m)
    return grid._replace(x_m_min=float(low[0]), y_m_min=float(low[1]), nx=_WINDOW[0], ny=_WINDOW[1])


def _some_road_user(scan: LabeledScan, rng: np.random.Generator) -> NDArray[np.float64]:
    """(2,) the place of one. Each kind has the same chance: cyclists are few, people are in every window."""
    kind = rng.choice(np.unique(scan.kinds))
    place: NDArray[np.float64] = scan.boxes[rng.choice(np.flatnonzero(scan.kinds == kind)), :2]
    return place


def varied(scan: LabeledScan, rng: np.random.Generator) -> LabeledScan:
    """The scan mirrored, turned, scaled, thinned and brightened."""
    points, boxes, is_older = scan.points.copy(), scan.boxes.copy(), scan.is_older
    if rng.random() < 0.5:
        points[:, 1] *= -1.0
        boxes[:, [1, 2, 7]] *= -1.0
    angle = rng.uniform(-0.5, 0.5) + np.pi * (rng.random() < 0.3)
    scale = rng.uniform(0.96, 1.04)
    cos, sin = np.cos(angle), np.sin(angle)
    turned = np.array([[cos, sin], [-sin, cos]])
    points[:, :2] = points[:, :2] @ (scale * turned)
    points[:, 2] = points[:, 2] * scale + rng.normal(0.0, 0.03)
    boxes[:, :2] = boxes[:, :2] @ (scale * turned)
    boxes[:, 6:8] = boxes[:, 6:8] @ (scale * turned)
    boxes[:, 3:6] *= scale
    boxes[:, 2] += angle
    points[:, 3] = np.clip(points[:, 3] * rng.uniform(0.5, 1.6), 0.0, 255.0)
    kept = np.ones(len(points), dtype=bool)
    hits = scan.hits
    if rng.random() < 0.4:
        share = rng.uniform(0.5, 1.0)
        kept &= rng.random(len(points)) < share
        hits = (hits * share).astype(np.int64)
    return LabeledScan(points[kept], is_older[kept], scan.older_s, scan.kinds, boxes, hits)
