"""The planes of one scan: ground and walls."""

import itertools
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from contract.geometry import Array
from workshop.calibration.cells import cell_numbers, thin


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """normal . p + offset_m = 0, the normal towards the sensor.

    points  (n, 3) on it, in the sensor's frame
    area_m2 that its points cover, in cells of half a metre
    """

    normal: Array
    offset_m: float
    points: Array
    area_m2: float

    @property
    def centre(self) -> Array:
        middle: Array = self.points.mean(axis=0)
        return middle


@dataclass(frozen=True, slots=True)
class PlaneSearch:
    """How planes are found.

    range_m_max    farther points are too few, and noisy in direction
    thickness_m    of a plane, to both sides, at first; then three times what its points deviate
    area_m2_min    a plane is no box or person
    points_min     of a plane
    planes_max     the largest ones
    triples        of points that are tried for each plane
    """

    range_m_max: float = 50.0
    thickness_m: float = 0.08
    thickness_m_min: float = 0.02
    area_m2_min: float = 3.0
    points_min: int = 80
    planes_max: int = 8
    triples: int = 1500
    seed: int = 1


_CELL_M = 0.5
# Cells of a plane that are so far apart belong together: rings on the ground are.
_GAP_M = 2.0
_THIN_M = 0.15
_BLOCK_M = 5.0
_SCORED_MAX = 4_000


def find_planes(points: Array, search: PlaneSearch) -> list[Plane]:
    """The planes of a scan (n, 3), the largest first. Deterministic."""
    rng = np.random.default_rng(search.seed)
    points = points.astype(np.float64)
    ranges = np.linalg.norm(points, axis=1)
    left = points[(ranges < search.range_m_max) & (ranges > 0.3)]
    planes: list[Plane] = []
    failures = 0
    while len(planes) < search.planes_max and failures < 3 and len(left) >= search.points_min:
        found = _largest(left, search, rng)
        if found is None:
            failures += 1
            continue
        on_plane, plane = found
        left = left[~on_plane]
        if plane is None:
            failures += 1
        else:
            planes.append(plane)
    return sorted(planes, key=lambda plane: -plane.area_m2)


def fit_plane(points: Array, weights: Array | None = None) -> tuple[Array, float, float]:
    """(normal towards the origin, offset, standard deviation) by least squares; points (n, 3)."""
    weights = np.ones(len(points)) if weights is None else weights
    centre = np.average(points, axis=0, weights=weights)
    centred = points - centre
    values, vectors = np.linalg.eigh((centred * weights[:, None]).T @ centred / weights.sum())
    normal = vectors[:, 0]
    offset = -float(normal @ centre)
    if offset < 0.0:
        normal, offset = -normal, -offset
    return normal, offset, float(np.sqrt(max(values[0], 0.0)))


def _largest(
    points: Array, search: PlaneSearch, rng: np.random.Generator
) -> tuple[np.ndarray, Plane | None] | None:
    """(which points are on it, the plane, None if it is too small) of the best triple; None without any."""
    thinned = thin(points, _THIN_M)
    if len(thinned) > _SCORED_MAX:
        thinned = thinned[rng.permutation(len(thinned))[:_SCORED_MAX]]
    normals, offsets = _hypotheses(thinned, search.triples, rng)
    if not len(normals):
        return None
    counts = np.zeros(len(normals))
    for begin in range(0, len(normals), 250):
        part = slice(begin, begin + 250)
        distances = np.abs(thinned @ normals[part].T + offsets[part])
        counts[part] = (distances < search.thickness_m).sum(axis=0)
    best = int(np.argmax(counts))
    normal, offset = normals[best], float(offsets[best])
    thickness = search.thickness_m
    for _ in range(4):
        on_plane = np.abs(points @ normal + offset) < thickness
        on_plane = _together(points, on_plane, normal)
        if on_plane.sum() < search.points_min:
            return on_plane, None
        normal, offset, deviation = fit_plane(points[on_plane])
        thickness = float(np.clip(3.0 * deviation, search.thickness_m_min, search.thickness_m))
    members = points[on_plane]
    area = _area_m2(members, normal)
    # What is left beside a plane (door frames, kerbs) would be found again as a plane of its own.
    beside = np.abs(points @ normal + offset) < search.thickness_m
    if area < search.area_m2_min:
        return beside, None
    return beside, Plane(normal, offset, members, area)


def _hypotheses(points: Array, count: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """(normals (k, 3), offsets (k,)) of triples of points that are within a block of each other."""
    shift = rng.uniform(0.0, 1.0, 3)
    _, block = np.unique(cell_numbers(points, _BLOCK_M, shift), return_inverse=True)
    order = np.argsort(block, kind="stable")
    sizes = np.bincount(block)
    begins = np.concatenate(([0], np.cumsum(sizes)[:-1]))
    seeds = rng.integers(0, len(points), count)
    chosen = block[seeds]
    a = points[seeds]
    b, c = (points[order[begins[chosen] + rng.integers(0, sizes[chosen])]] for _ in range(2))
    crosses = np.cross(b - a, c - a)
    doubled_areas = np.linalg.norm(crosses, axis=1)
    # Thin triangles have no normal to speak of.
    longest = np.maximum(np.linalg.norm(b - a, axis=1), np.linalg.norm(c - a, axis=1))
    fine = (doubled_areas > 0.4) & (doubled_areas > 0.2 * longest**2)
    normals = crosses[fine] / doubled_areas[fine, None]
    return normals, -np.einsum("ij,ij->i", normals, a[fine])


def _together(points: Array, on_plane: np.ndarray, normal: Array) -> np.ndarray:
    """Those points of a plane that are in its largest connected part."""
    members = np.flatnonzero(on_plane)
    cells = _cells(points[members], normal, _GAP_M)
    grid = np.zeros(cells.max(axis=0) + 1 if len(cells) else (1, 1), dtype=bool)
    grid[tuple(cells.T)] = True
    labels, parts = ndimage.label(grid, structure=np.ones((3, 3)))
    if parts <= 1:
        return on_plane
    of_point = labels[tuple(cells.T)]
    # By cells, not by points: the nearest part has most points.
    sizes = [np.count_nonzero(labels == part) for part in range(1, parts + 1)]
    kept = np.zeros_like(on_plane)
    kept[members[of_point == 1 + int(np.argmax(sizes))]] = True
    return kept


def _area_m2(points: Array, normal: Array) -> float:
    return len(np.unique(cell_numbers(points @ plane_axes(normal).T, _CELL_M))) * _CELL_M**2


def _cells(points: Array, normal: Array, cell_m: float) -> np.ndarray:
    """(n, 2) whole numbers from 0: cells in the plane."""
    flat = points @ plane_axes(normal).T
    cells = np.floor(flat / cell_m).astype(np.int64)
    return cells - cells.min(axis=0) if len(cells) else cells


def plane_axes(normal: Array) -> Array:
    """(2, 3) two axes in the plane."""
    axes: Array = axes_of(normal[None])[0]
    return axes


def axes_of(normals: Array) -> Array:
    """(n, 2, 3) two axes in each of the planes with these unit normals (n, 3)."""
    helpers = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    first = np.cross(normals, helpers)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack((first, np.cross(normals, first)), axis=1)


def triples_of(count: int) -> list[tuple[int, int, int]]:
    """All choices of three among so many."""
    return list(itertools.combinations(range(count), 3))
