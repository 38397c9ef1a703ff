"""Scan matching by distances from points to lines (Censi 2008), with robust weights and a prior."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, IntArray, wrap_angle
from vehicle_agent.localization.laser.point_index import PointIndex, nearest
from vehicle_agent.localization.laser.surfaces import Surface

_ITERATIONS_MAX = 25
_CONVERGED_M, _CONVERGED_RAD = 2e-5, 1e-5
# Normals of one wall seen from two sides point apart; they are not the same surface.
_SAME_SIDE_COS = 0.5


class MatchParams(msgspec.Struct, frozen=True):
    """How points find their lines.

    distance_m_first, distance_m_last  how far a point may lie from its reference point, at the first step and
                                       after a few; it halves in between
    residual_m      scale of the robust weight (Geman-McClure's): a point this far off counts a quarter
    noise_m         standard deviation of one reading's distance to its line
    normal_variance of a normal's direction (rad2): along a bare corridor, normals that are off seem to say
                    where the laser is; so much of the greatest information is taken from every direction
    independent     share of the points that count as independent of each other: neighbours share their errors
    """

    distance_m_first: float = 0.5
    distance_m_last: float = 0.15
    residual_m: float = 0.08
    noise_m: float = 0.02
    independent: float = 0.5
    normal_variance: float = 0.015


class Match(msgspec.Struct, frozen=True):
    """Where the laser was, by its scan.

    pose          (3,) of the laser in the reference's frame
    information   (3, 3) inverse covariance of the pose (1/m2, 1/rad2), from the scan alone
    inlier_ratio  share of the scan's points that lie on a line of the reference
    residual_m    root mean square of the inliers' distances to their lines
    """

    pose: Array
    information: Array
    inlier_ratio: float
    residual_m: float


def match_to_lines(
    surface: Surface,
    reference: PointIndex,
    start: Array,
    prior_information: Array,
    params: MatchParams,
) -> Match:
    """The pose at which the scan lies on the reference's lines.

    start              (3,) where the search begins; also the mean of the prior
    prior_information  (3, 3); zeros for none. It keeps what the scan cannot see, as along a corridor
    """
    pose, information, inlier_ratio, residual_m = _match(
        surface.points_laser,
        surface.normals_laser,
        reference.points,
        reference.normals,
        reference.starts,
        reference.origin_x_m,
        reference.origin_y_m,
        reference.cell_m,
        reference.columns,
        reference.rows,
        np.asarray(start, dtype=np.float64),
        np.asarray(prior_information, dtype=np.float64),
        min(params.distance_m_first, reference.cell_m),
        min(params.distance_m_last, reference.cell_m),
        params.residual_m,
        params.independent / params.noise_m**2,
        params.normal_variance,
    )
    return Match(pose, information, inlier_ratio, residual_m)


@njit(cache=True)
def _match(
    points: Array,
    normals: Array,
    reference_points: Array,
    reference_normals: Array,
    starts: IntArray,
    origin_x_m: float,
    origin_y_m: float,
    cell_m: float,
    columns: int,
    rows: int,
    start: Array,
    prior_information: Array,
    distance_m_first: float,
    distance_m_last: float,
    residual_scale_m: float,
    weight_1pm2: float,
    normal_variance: float,
) -> tuple[Array, Array, float, float]:
    pose = start.copy()
    information = np.zeros((3, 3))
    inlier_ratio, residual_m = 0.0, 0.0
    n = points.shape[0]
    if n == 0:
        return pose, information, inlier_ratio, residual_m
    distance_m = distance_m_first
    jacobian = np.empty(3)
    scale2 = residual_scale_m * residual_scale_m
    for _ in range(_ITERATIONS_MAX):
        information = np.zeros((3, 3))
        gradient = np.zeros(3)
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        inliers, squares = 0, 0.0
        for i in range(n):
            rx = cos * points[i, 0] - sin * points[i, 1]
            ry = sin * points[i, 0] + cos * points[i, 1]
            x, y = rx + pose[0], ry + pose[1]
            j = nearest(
                reference_points, starts, origin_x_m, origin_y_m, cell_m, columns, rows, x, y, distance_m
            )
            if j < 0:
                continue
            nx, ny = reference_normals[j, 0], reference_normals[j, 1]
            if normals[i, 0] != 0.0 or normals[i, 1] != 0.0:
                own_x = cos * normals[i, 0] - sin * normals[i, 1]
                own_y = sin * normals[i, 0] + cos * normals[i, 1]
                if own_x * nx + own_y * ny < _SAME_SIDE_COS:
                    continue
            r = nx * (x - reference_points[j, 0]) + ny * (y - reference_points[j, 1])
            share = scale2 / (scale2 + r * r)
            weight = weight_1pm2 * share * share
            jacobian[0], jacobian[1], jacobian[2] = nx, ny, ny * rx - nx * ry
            for a in range(3):
                gradient[a] += weight * jacobian[a] * r
                for b in range(3):
                    information[a, b] += weight * jacobian[a] * jacobian[b]
            if abs(r) < residual_scale_m:
                inliers += 1
                squares += r * r
        _without_normal_noise(information, gradient, normal_variance)
        inlier_ratio = inliers / n
        residual_m = math.sqrt(squares / inliers) if inliers else 0.0
        away = np.array([pose[0] - start[0], pose[1] - start[1], wrap_angle(pose[2] - start[2])])
        system = information + prior_information
        for a in range(3):
            # The last digits of a scan that sees nothing: the step is then zero.
            system[a, a] += 1e-6
        step = np.linalg.solve(system, -(gradient + prior_information @ away))
        pose[0] += step[0]
        pose[1] += step[1]
        pose[2] = wrap_angle(pose[2] + step[2])
        moved_m = math.hypot(step[0], step[1])
        if distance_m <= distance_m_last and moved_m < _CONVERGED_M and abs(step[2]) < _CONVERGED_RAD:
            break
        distance_m = max(distance_m_last, 0.7 * distance_m)
    return pose, information, inlier_ratio, residual_m


@njit(cache=True)
def _without_normal_noise(information: Array, gradient: Array, normal_variance: float) -> None:
    """Scales what the lines say along each axis of their translational information (3, 3), (3,), in place."""
    a, b, c = information[0, 0], information[0, 1], information[1, 1]
    half_trace, half_difference = 0.5 * (a + c), 0.5 * (a - c)
    root = math.hypot(half_difference, b)
    greatest, least = half_trace + root, half_trace - root
    if greatest <= 0.0:
        return
    noise = normal_variance * greatest
    across = math.sqrt(max(0.0, 1.0 - normal_variance))
    along = math.sqrt(max(0.0, 1.0 - noise / least)) if least > 0.0 else 0.0
    angle = 0.5 * math.atan2(b, half_difference)
    cos, sin = math.cos(angle), math.sin(angle)
    scale = np.eye(3)
    scale[0, 0] = across * cos * cos + along * sin * sin
    scale[0, 1] = scale[1, 0] = (across - along) * cos * sin
    scale[1, 1] = across * sin * sin + along * cos * cos
    information[:] = scale @ information @ scale
    gradient[:] = scale @ gradient
