"""What the network should answer to a labeled scan: heat of object middles, and the boxes at them."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from vehicle_agent.perception.pillars.grid import STRIDE, PillarGrid
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

Array32 = NDArray[np.float32]
Ints = NDArray[np.int64]

KINDS = (PEDESTRIAN, CYCLIST, VEHICLE)
# Boxes with fewer returns of the newer turn are neither wanted nor wrong.
HITS_MIN = 5
# Offset x, y; logarithms of length, width, height; cosine, sine of twice the yaw; velocity x, y; direction.
BOX_CHANNELS = 10
# Spread of the heat around a middle, m.
_SPREADS_M = (0.3, 0.35, 0.55)
_HEAT_MIN = 0.05
# Cells this hot learn the box too, since the hottest one may be beside the middle.
_BOX_HEAT_MIN = 0.5


class Targets(NamedTuple):
    """heat, heat_weight (kinds, h, w); boxes (BOX_CHANNELS, h, w); box_weight, turned_weight (h, w).

    turned_weight  where the yaw counts, too: a person is a disc
    """

    heat: Array32
    heat_weight: Array32
    boxes: Array32
    box_weight: Array32
    turned_weight: Array32


def targets_of(kinds: NDArray[np.int64], boxes: Array, hits: NDArray[np.int64], grid: PillarGrid) -> Targets:
    """Targets of boxes (m, 8) as in `LabeledScan`."""
    cell_m = grid.cell_m * STRIDE
    w, h = grid.nx // STRIDE, grid.ny // STRIDE
    targets = Targets(
        np.zeros((len(KINDS), h, w), np.float32), np.ones((len(KINDS), h, w), np.float32),
        np.zeros((BOX_CHANNELS, h, w), np.float32), np.zeros((h, w), np.float32),
        np.zeros((h, w), np.float32),
    )  # fmt: skip
    for kind, box, count in zip(kinds, boxes, hits, strict=True):
        u, v = (box[0] - grid.x_m_min) / cell_m, (box[1] - grid.y_m_min) / cell_m
        if not (0.0 <= u < w and 0.0 <= v < h):
            continue
        reach = math.ceil(2.5 * _SPREADS_M[kind] / cell_m)
        if count < HITS_MIN:
            reach = max(reach, math.ceil(0.5 * box[3] / cell_m))
        rows = np.arange(max(0, int(v) - reach), min(h, int(v) + reach + 1), dtype=np.int64)
        columns = np.arange(max(0, int(u) - reach), min(w, int(u) + reach + 1), dtype=np.int64)
        part = np.ix_(rows, columns)
        if count < HITS_MIN:
            targets.heat_weight[:, rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1] = 0.0
            continue
        apart = ((rows + 0.5 - v) ** 2)[:, None] + (columns + 0.5 - u) ** 2
        heat = np.exp(-0.5 * apart * (cell_m / _SPREADS_M[kind]) ** 2)
        # The cell of the middle is the one that must be found.
        heat /= heat.max()
        heat[heat < _HEAT_MIN] = 0.0
        targets.heat[kind][part] = np.maximum(targets.heat[kind][part], heat)
        _write_box(targets, box, int(kind), (u, v), (rows, columns), heat)
    # What is wanted counts, also beside what is not.
    targets.heat_weight[:, targets.heat.max(axis=0) > _BOX_HEAT_MIN] = 1.0
    return targets


def _write_box(
    targets: Targets,
    box: Array,
    kind: int,
    middle: tuple[float, float],
    part: tuple[Ints, Ints],
    heat: Array,
) -> None:
    for row, v in enumerate(part[0]):
        for column, u in enumerate(part[1]):
            weight = heat[row, column]
            if weight < _BOX_HEAT_MIN or weight < targets.box_weight[v, u]:
                continue
            targets.box_weight[v, u] = weight
            targets.turned_weight[v, u] = 0.0 if kind == PEDESTRIAN else weight
            targets.boxes[:, v, u] = (
                middle[0] - (u + 0.5), middle[1] - (v + 0.5), *np.log(np.maximum(box[3:6], 0.1)),
                math.cos(2.0 * box[2]), math.sin(2.0 * box[2]), box[6], box[7], math.cos(box[2]) > 0.0,
            )  # fmt: skip
