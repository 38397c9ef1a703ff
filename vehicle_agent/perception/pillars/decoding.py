"""The network's answer to a scan, as boxes of objects."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array
from vehicle_agent.perception.pillars.grid import STRIDE, PillarGrid
from vehicle_agent.perception.pillars.overlap import kept_of
from vehicle_agent.signals import PEDESTRIAN

Array32 = NDArray[np.float32]

# A body that moves so fast faces the way it moves.
_MOVING_MPS = 0.7


class DecodingParams(NamedTuple):
    """score_min: of an object; iou_max: of two objects; at most candidates_max before and objects_max after
    overlapping ones are left out, best first.
    """

    score_min: float = 0.15
    iou_max: float = 0.2
    candidates_max: int = 800
    objects_max: int = 400


class Detections(NamedTuple):
    """kinds (n,), scores (n,), boxes (n, 8): x, y, yaw, length, width, height, velocity x, y; best first."""

    kinds: NDArray[np.int64]
    scores: Array
    boxes: Array


def decoded(heat: Array32, boxes: Array32, grid: PillarGrid, params: DecodingParams) -> Detections:
    """Objects of heat (kinds, h, w), as logits, and boxes (10, h, w): x, y from the cell's middle in cells,
    logarithms of length, width, height, cosine and sine of twice the yaw, velocity x, y, direction.

    The kinds are in the order of TRACK_KINDS. What is not finite is no object.
    """
    logit_min = math.log(params.score_min / (1.0 - params.score_min))
    peaks = _peaks(heat, logit_min)
    scores = 1.0 / (1.0 + np.exp(-heat[peaks[:, 0], peaks[:, 1], peaks[:, 2]].astype(np.float64)))
    order = np.argsort(-scores, kind="stable")[: params.candidates_max]
    peaks, scores = peaks[order], scores[order]
    found = _boxes_at(peaks, boxes, grid)
    whole = np.isfinite(found).all(axis=1)
    peaks, scores, found = peaks[whole], scores[whole], found[whole]
    kept = kept_of(found, params.iou_max, params.objects_max)
    return Detections(peaks[kept, 0], scores[kept], found[kept])


def with_velocities(found: Detections, velocities_mps: Array) -> Detections:
    """The same objects with these velocities (n, 2); what moves faces the way it moves."""
    boxes = found.boxes.copy()
    boxes[:, 6:8] = velocities_mps
    vx, vy = velocities_mps.T
    # NaN is no motion.
    moving = np.hypot(vx, vy) > _MOVING_MPS
    backwards = moving & (vx * np.cos(boxes[:, 2]) + vy * np.sin(boxes[:, 2]) < 0.0)
    yaw = np.where(
        moving & (found.kinds == PEDESTRIAN), np.arctan2(vy, vx), boxes[:, 2] + math.pi * backwards
    )
    boxes[:, 2] = np.arctan2(np.sin(yaw), np.cos(yaw))
    return Detections(found.kinds, found.scores, boxes)


def _boxes_at(peaks: NDArray[np.int64], boxes: Array32, grid: PillarGrid) -> Array:
    cell_m = grid.cell_m * STRIDE
    at = boxes[:, peaks[:, 1], peaks[:, 2]].astype(np.float64)
    found: Array = np.empty((len(peaks), 8))
    found[:, 0] = grid.x_m_min + cell_m * (peaks[:, 2] + 0.5 + at[0])
    found[:, 1] = grid.y_m_min + cell_m * (peaks[:, 1] + 0.5 + at[1])
    # A size beyond 20 m or below 10 cm is no road user's.
    found[:, 3:6] = np.exp(np.clip(at[2:5], math.log(0.1), math.log(20.0))).T
    found[:, 6], found[:, 7] = at[7], at[8]
    # Half of an angle points forwards, so the direction bit says whether the body does.
    yaw = 0.5 * np.arctan2(at[6], at[5])
    yaw = yaw + math.pi * (at[9] <= 0.0)
    found[:, 2] = np.arctan2(np.sin(yaw), np.cos(yaw))
    return found


@njit(cache=True)
def _peaks(heat: Array32, logit_min: float) -> NDArray[np.int64]:
    """(n, 3) kind, row, column of cells that are hotter than their eight neighbours."""
    kinds, h, w = heat.shape
    found = np.empty((kinds * h * w, 3), np.int64)
    count = 0
    for kind in range(kinds):
        for v in range(h):
            for u in range(w):
                value = heat[kind, v, u]
                if not value >= logit_min:
                    continue
                is_peak = True
                for a in range(max(0, v - 1), min(h, v + 2)):
                    for b in range(max(0, u - 1), min(w, u + 2)):
                        other = heat[kind, a, b]
                        # Of equal neighbours the first one stays.
                        if other > value or (other == value and (a < v or (a == v and b < u))):
                            is_peak = False
                if is_peak:
                    found[count, 0], found[count, 1], found[count, 2] = kind, v, u
                    count += 1
    return found[:count].copy()
