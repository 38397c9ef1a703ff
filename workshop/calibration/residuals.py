"""How well poses of lidars fit their scans: what was minimised, and what was not."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from contract.geometry import Array
from contract.transforms import moved
from workshop.calibration.cells import thin
from workshop.calibration.registration import Surfaces

# Farther points belong to what the reference does not see.
_NEAR_M = 1.0
_CAP_M = 0.3
_THIN_M = 0.1
_NEIGHBOURHOOD_M = 0.5
_OF_EACH_MIN = 4
_PLACES_MAX = 3_000


@dataclass(frozen=True, slots=True)
class Residual:
    """One lidar's points at one pose.

    plane_m      root mean square of the distances from the reference's surfaces, each at most 0.3 m
    median_m     median of the same distances
    thickness_m  mean standard deviation across the surface of what both lidars see within half a metre; the
                 optimisation does not know it
    on_surfaces  share of the points within a metre of a surface that are within 5 cm of it
    """

    plane_m: float
    median_m: float
    thickness_m: float
    on_surfaces: float


def distance_m(surfaces: Surfaces, other: Array, transform: Array) -> float:
    """Root mean square of the capped distances of the scan `other` (n, 3) from the surfaces."""
    apart = _distances(surfaces, moved(transform, thin(other, _THIN_M)))
    return float(np.sqrt(np.mean(np.minimum(apart, _CAP_M) ** 2))) if len(apart) else _CAP_M


def _distances(surfaces: Surfaces, points: Array) -> Array:
    """Of the points near a surface."""
    distances, which = surfaces.tree.query(points, distance_upper_bound=_NEAR_M)
    near = np.isfinite(distances)
    off = points[near] - surfaces.points[which[near]]
    apart: Array = np.abs(np.einsum("ij,ij->i", surfaces.normals[which[near]], off))
    return apart


def residual(reference: Array, surfaces: Surfaces, other: Array, transform: Array) -> Residual:
    """Of the scan `other` (n, 3) against the reference's (m, 3) and its surfaces, at T_reference_other."""
    points = moved(transform, thin(other, _THIN_M))
    apart = _distances(surfaces, points)
    if not len(apart):
        return Residual(_CAP_M, _CAP_M, _CAP_M, 0.0)
    capped = np.minimum(apart, _CAP_M)
    return Residual(
        float(np.sqrt(np.mean(capped**2))),
        float(np.median(capped)),
        _thickness_m(reference, points),
        float(np.mean(apart < 0.05)),
    )


def _thickness_m(reference: Array, other: Array) -> float:
    """Mean thickness where both see the same; places are every so many points of the other."""
    reference = thin(reference, _THIN_M)
    ours, theirs = cKDTree(reference), cKDTree(other)
    places = other[:: max(1, len(other) // _PLACES_MAX)]
    found = []
    for mine, its in zip(
        ours.query_ball_point(places, _NEIGHBOURHOOD_M),
        theirs.query_ball_point(places, _NEIGHBOURHOOD_M),
        strict=True,
    ):
        if len(mine) < _OF_EACH_MIN or len(its) < _OF_EACH_MIN:
            continue
        together = np.vstack((reference[mine], other[its]))
        centred = together - together.mean(axis=0)
        found.append(max(float(np.linalg.eigvalsh(centred.T @ centred / len(together))[0]), 0.0) ** 0.5)
    return float(np.mean(found)) if found else _CAP_M
