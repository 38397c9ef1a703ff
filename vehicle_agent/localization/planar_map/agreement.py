"""How a scan speaks for a pose in the map: by the things it sees, of which each counts once.

The beams that end on one wall, or on the truck that hides it, err together. So the unit is the thing: ends
that lie beside each other. Each is on a wall of the map, or speaks against the pose by how it misses.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, IntArray
from vehicle_agent.localization.monte_carlo.likelihood_field import Float32Array, LikelihoodField

# Entries of what is counted.
ON_WALL, THROUGH_WALL, BEFORE_WALL, BESIDE_WALLS = range(4)
# A cell of a wall; and near enough to one.
_WALL, _NEAR = 0.999, 0.3


class EvidenceParams(msgspec.Struct, frozen=True):
    """What a thing says of a pose: logarithms of how much likelier it is if the pose is right than if wrong.

    on_wall        for the pose: the thing lies on a wall of the map
    through_wall   against it: the beams passed through a wall
    before_wall    it stands before a wall that it hides
    beside_walls   it stands where the map has nothing at all, or the map ends
    gap_m, gap_ratio  ends of neighbouring beams that lie so far apart, and by this share of the distance,
                   are on two things
    clear_m        a wall within so much of the beam's end, or of the laser, is not passed through
    far_m          walls are looked for so far along a beam
    prior          evidence for and against, of equal weight, that is there before the scan: a few things
                   prove little
    """

    on_wall: float = 1.9
    through_wall: float = 2.7
    before_wall: float = 1.4
    beside_walls: float = 1.4
    gap_m: float = 0.6
    gap_ratio: float = 0.06
    clear_m: float = 0.5
    far_m: float = 30.0
    prior: float = 4.0


class Evidence(msgspec.Struct, frozen=True):
    """What a scan says: `on` for a pose, `against` it; things_on_walls: how many of its things lie there."""

    on: float
    against: float
    things_on_walls: float

    @property
    def balance(self) -> float:
        """What speaks for the pose, less what speaks against it."""
        return self.on - self.against

    def agreement(self, prior: float) -> float:
        """Share of what speaks for the pose, 0..1; one half where nothing is seen."""
        return (self.on + 0.5 * prior) / max(self.on + self.against + prior, 1e-9)


def things_of(points: Array, params: EvidenceParams) -> IntArray:
    """(m,) the number of the thing on which each beam ends; points (m, 2), laser frame, by their angles."""
    if not len(points):
        return np.zeros(0, dtype=np.int64)
    apart = np.hypot(points[1:, 0] - points[:-1, 0], points[1:, 1] - points[:-1, 1])
    distance = np.hypot(points[1:, 0], points[1:, 1])
    begins = np.concatenate(([False], apart > params.gap_m + params.gap_ratio * distance))
    found: IntArray = np.cumsum(begins).astype(np.int64)
    return found


def evidence_at(
    points: Array, things: IntArray, pose: Array, field: LikelihoodField, params: EvidenceParams
) -> Evidence:
    """What a scan, points (m, 2) on things (m,), says of a pose (3,) of the laser in the map frame."""
    counts = counted_things(
        points, things, pose, field.hit, field.origin_x_m, field.origin_y_m, field.cell_m, params.clear_m,
        params.far_m,
    )  # fmt: skip
    against = (
        params.through_wall * counts[THROUGH_WALL]
        + params.before_wall * counts[BEFORE_WALL]
        + params.beside_walls * counts[BESIDE_WALLS]
    )
    return Evidence(params.on_wall * float(counts[ON_WALL]), float(against), float(counts[ON_WALL]))


@njit(cache=True)
def counted_things(
    points: Array, things: IntArray, pose: Array, hit: Float32Array, origin_x_m: float, origin_y_m: float,
    cell_m: float, clear_m: float, far_m: float,
) -> Array:  # fmt: skip
    """(4,) things on a wall, behind one, before one, where there is none; each counts one in all.

    hit (rows, columns) nearness of walls, of `LikelihoodField`
    """
    counts = np.zeros(4)
    if points.shape[0] == 0:
        return counts
    sizes = np.zeros(things[-1] + 1)
    for i in range(points.shape[0]):
        sizes[things[i]] += 1.0
    rows, columns = hit.shape
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for i in range(points.shape[0]):
        share = 1.0 / sizes[things[i]]
        dx, dy = cos * points[i, 0] - sin * points[i, 1], sin * points[i, 0] + cos * points[i, 1]
        length = max(math.hypot(dx, dy), 1e-9)
        column = math.floor((pose[0] + dx - origin_x_m) / cell_m)
        row = math.floor((pose[1] + dy - origin_y_m) / cell_m)
        if not (0 <= row < rows and 0 <= column < columns):
            counts[BESIDE_WALLS] += share
            continue
        if hit[row, column] > _NEAR:
            counts[ON_WALL] += share
            continue
        kind, along = BESIDE_WALLS, clear_m
        while along < far_m:
            column = math.floor((pose[0] + along / length * dx - origin_x_m) / cell_m)
            row = math.floor((pose[1] + along / length * dy - origin_y_m) / cell_m)
            if 0 <= row < rows and 0 <= column < columns and hit[row, column] > _WALL:
                kind = THROUGH_WALL if along < length - clear_m else BEFORE_WALL
                break
            along += cell_m
        counts[kind] += share
    return counts
