"""Four stages of GEM, section VI: field of view, intensity, radius outliers, statistical outliers."""

import math

import msgspec
import numpy as np
from scipy.spatial import cKDTree

from contract.geometry import Array, BoolArray


class SignStages(msgspec.Struct, frozen=True):
    """Parameters of the stages; the field is in the base frame.

    x_m, z_m           of the first lidar
    ahead_m, side_m    stage 1: in front of the lidar, and at most so far to each side
    intensity_min      stage 2: of the sensor. Calibrated reflectivity of 0..255 has retro-reflectors above
                       100; the paper's sensor gave them 85
    radius_m, neighbours_min  stage 3: points with fewer neighbours within the radius go, until none does
    statistics_of, deviations  stage 4: points whose mean distance to their nearest points is above the mean
                       of all by more than so many standard deviations go
    points_max         the nearest so many reflecting points are looked at
    step_ratio         angle between two firings of a ring, rad
    """

    x_m: float = 0.0
    z_m: float = 2.2
    ahead_m: float = 32.0
    side_m: float = 10.0
    intensity_min: float = 100.5
    radius_m: float = 0.5
    neighbours_min: int = 3
    statistics_of: int = 4
    deviations: float = 3.0
    points_max: int = 1500
    step_ratio: float = 0.0035


def reflecting(points_base: Array, intensities: Array, stages: SignStages) -> Array:
    """(k, 3) stages 1 and 2: the retro-reflecting points ahead, the nearest `points_max` of them.

    points_base (n, 3), intensities (n,). Points that are not finite are left out.
    """
    bright = np.flatnonzero(intensities >= stages.intensity_min)
    points = np.asarray(points_base[bright], dtype=np.float64)
    x, y = points[:, 0] - stages.x_m, points[:, 1]
    with np.errstate(invalid="ignore"):
        inside = (x > 0.0) & (x <= stages.ahead_m) & (np.abs(y) <= stages.side_m) & np.isfinite(points[:, 2])
    points = points[inside]
    if len(points) > stages.points_max:
        nearest = np.argsort(np.hypot(points[:, 0], points[:, 1]), kind="stable")[: stages.points_max]
        points = points[np.sort(nearest)]
    return points


def without_outliers(points: Array, stages: SignStages) -> Array:
    """(k, 3) of points (n, 3): stages 3 and 4."""
    points = points[_in_company(points, stages)]
    return points[_in_statistics(points, stages)]


def _in_company(points: Array, stages: SignStages) -> BoolArray:
    """(n,) stage 3. A point's neighbours go with it, so the removal is repeated until it ends."""
    kept: BoolArray = np.ones(len(points), np.bool_)
    if not len(points):
        return kept
    pairs = cKDTree(points).query_pairs(stages.radius_m, output_type="ndarray")
    while True:
        counts = np.bincount(pairs.ravel(), minlength=len(points))
        kept = counts >= stages.neighbours_min
        still = kept[pairs[:, 0]] & kept[pairs[:, 1]]
        if still.all():
            return kept
        pairs = pairs[still]


def _in_statistics(points: Array, stages: SignStages) -> BoolArray:
    """(n,) stage 4, as in the Point Cloud Library's StatisticalOutlierRemoval (Rusu 2010)."""
    if len(points) <= stages.statistics_of:
        return np.ones(len(points), np.bool_)
    distances, _ = cKDTree(points).query(points, k=stages.statistics_of + 1)
    # The samples of one ring are r d(azimuth) apart, so distances grow with the range.
    ranges = np.maximum(1.0, np.hypot(points[:, 0] - stages.x_m, points[:, 1]))
    means = distances[:, 1:].mean(axis=1) / ranges
    limit = float(means.mean()) + stages.deviations * float(means.std())
    usual: BoolArray = means <= limit + math.ulp(1.0)
    return usual
