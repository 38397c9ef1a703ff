"""The surface that a scan sees: its points, thinned out, with the normal of the line that each lies on."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array

# A point and its neighbours make a line where they lie this flat (ratio of the spreads).
_FLATNESS_MAX = 0.04
_LINE_POINTS_MIN = 4


class SurfaceParams(msgspec.Struct, frozen=True):
    """How a scan becomes points.

    range_m_max   farther readings are left out: their beams lie too wide apart to make a line
    spacing_m     of the kept points along a wall, so that near walls do not outvote far ones
    line_m        half the length of wall from which a normal is taken
    gap_m         readings farther apart than this belong to two surfaces, where their directions lie close;
                  the gap grows with the distance between two beams
    """

    range_m_max: float = 40.0
    spacing_m: float = 0.05
    line_m: float = 0.2
    gap_m: float = 0.15


class Surface(msgspec.Struct, frozen=True):
    """points_laser (n, 2) in metres; normals_laser (n, 2) unit vectors towards the laser, zero where a point
    lies on no line."""

    points_laser: Array
    normals_laser: Array

    def __len__(self) -> int:
        return len(self.points_laser)


def scan_surface(ranges_m: Array, angles_rad: Array, params: SurfaceParams) -> Surface:
    """The surface of one scan; empty where it has no return.

    ranges_m    (m,) distances; NaN, infinite, zero, negative and too far readings are no return
    angles_rad  (m,) directions in the laser's frame, in even steps
    """
    points, normals = _surface(
        ranges_m, angles_rad, params.range_m_max, params.spacing_m, params.line_m, params.gap_m
    )
    return Surface(points, normals)


@njit(cache=True)
def _surface(
    ranges_m: Array, angles_rad: Array, range_m_max: float, spacing_m: float, line_m: float, gap_m: float
) -> tuple[Array, Array]:
    count = ranges_m.shape[0]
    all_points = np.empty((count, 2))
    distances = np.empty(count)
    n = 0
    for i in range(count):
        if 0.0 < ranges_m[i] <= range_m_max:
            all_points[n, 0] = ranges_m[i] * math.cos(angles_rad[i])
            all_points[n, 1] = ranges_m[i] * math.sin(angles_rad[i])
            distances[n] = ranges_m[i]
            n += 1
    step_rad = abs(angles_rad[1] - angles_rad[0]) if count > 1 else 0.0
    points, normals = np.empty((n, 2)), np.zeros((n, 2))
    kept = 0
    for i in range(n):
        if kept:
            dx, dy = all_points[i, 0] - points[kept - 1, 0], all_points[i, 1] - points[kept - 1, 1]
            if dx * dx + dy * dy < spacing_m * spacing_m:
                continue
        points[kept] = all_points[i]
        beam_gap_m = distances[i] * step_rad
        _line_normal(all_points, n, i, max(line_m, 3.5 * beam_gap_m), gap_m + 4.0 * beam_gap_m, normals[kept])
        kept += 1
    return points[:kept].copy(), normals[:kept].copy()


@njit(cache=True)
def _line_normal(points: Array, n: int, i: int, line_m: float, gap_m: float, normal: Array) -> None:
    """Fits a line to the neighbours of point i on the same surface; writes its normal, or leaves zeros."""
    first, last = i, i
    while first > 0 and _is_next(points, i, first, first - 1, line_m, gap_m):
        first -= 1
    while last < n - 1 and _is_next(points, i, last, last + 1, line_m, gap_m):
        last += 1
    used = last - first + 1
    if used < _LINE_POINTS_MIN:
        return
    mx, my = 0.0, 0.0
    for j in range(first, last + 1):
        mx += points[j, 0]
        my += points[j, 1]
    mx /= used
    my /= used
    sxx, sxy, syy = 0.0, 0.0, 0.0
    for j in range(first, last + 1):
        dx, dy = points[j, 0] - mx, points[j, 1] - my
        sxx += dx * dx
        sxy += dx * dy
        syy += dy * dy
    half_trace, half_difference = 0.5 * (sxx + syy), 0.5 * (sxx - syy)
    root = math.hypot(half_difference, sxy)
    if half_trace - root > _FLATNESS_MAX * (half_trace + root):
        return
    # The direction of the line has half the angle of (half_difference, sxy).
    along_rad = 0.5 * math.atan2(sxy, half_difference)
    nx, ny = -math.sin(along_rad), math.cos(along_rad)
    if nx * points[i, 0] + ny * points[i, 1] > 0.0:
        nx, ny = -nx, -ny
    normal[0], normal[1] = nx, ny


@njit(cache=True)
def _is_next(points: Array, centre: int, at: int, to: int, line_m: float, gap_m: float) -> bool:
    """Whether the surface goes on from one point to the next, within the line's length of the centre."""
    reach = math.hypot(points[to, 0] - points[centre, 0], points[to, 1] - points[centre, 1])
    gap = math.hypot(points[to, 0] - points[at, 0], points[to, 1] - points[at, 1])
    return reach <= line_m and gap <= gap_m
