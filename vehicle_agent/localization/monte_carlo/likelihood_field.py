"""The likelihood field of an occupancy map: what a beam that ends in a cell says (Thrun et al. 2005, 6.4)."""

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from contract.geometry import Array
from contract.occupancy.occupancy_map import FREE, OCCUPIED, OccupancyMap

Float32Array = NDArray[np.float32]


class FieldParams(msgspec.Struct, frozen=True):
    """The measurement model.

    hit_std_m     of a beam's end about the nearest wall: range noise, map cells, small changes
    outlier_ratio share of beams that say nothing of the map: people, new things, broken readings. Their
                  likelihood is the same everywhere, so that they cannot outvote the others
    coarse_std_m  as hit_std_m, for poses on a coarse lattice
    """

    hit_std_m: float = 0.08
    outlier_ratio: float = 0.35
    coarse_std_m: float = 0.2


class LikelihoodField(msgspec.Struct, frozen=True):
    """The map as beams see it.

    hit             (rows, columns) how near a wall is, 0..1: exp(-d^2 / 2 hit_std^2)
    log_likelihood  (rows, columns) logarithm of the mixture of hits and outliers
    coarse          the same with coarse_std_m
    free            (k, 2) the middles of the free cells
    outside         the logarithm where a beam ends outside the map
    """

    hit: Float32Array
    log_likelihood: Float32Array
    coarse: Float32Array
    free: Array
    outside: float
    cell_m: float
    origin_x_m: float
    origin_y_m: float


def likelihood_field(occupancy: OccupancyMap, params: FieldParams) -> LikelihoodField:
    """The field of this map."""
    is_wall = occupancy.cells == OCCUPIED
    # Without any wall every distance is one from nowhere.
    distances_m = (
        distance_transform_edt(~is_wall) * occupancy.cell_m
        if is_wall.any()
        else np.full(is_wall.shape, np.inf)
    )
    hit = np.exp(-0.5 * (distances_m / params.hit_std_m) ** 2)
    coarse_hit = np.exp(-0.5 * (distances_m / params.coarse_std_m) ** 2)
    rows, columns = np.nonzero(occupancy.cells == FREE)
    origin = np.array([occupancy.origin_x_m, occupancy.origin_y_m])
    free = (np.stack([columns, rows], axis=1) + 0.5) * occupancy.cell_m + origin
    return LikelihoodField(
        hit.astype(np.float32),
        _mixed(hit, params).astype(np.float32),
        _mixed(coarse_hit, params).astype(np.float32),
        free,
        float(np.log(params.outlier_ratio)),
        occupancy.cell_m,
        occupancy.origin_x_m,
        occupancy.origin_y_m,
    )


def _mixed(hit: Array, params: FieldParams) -> Array:
    mixed: Array = np.log((1.0 - params.outlier_ratio) * hit + params.outlier_ratio)
    return mixed
