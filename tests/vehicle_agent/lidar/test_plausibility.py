"""A scan of a working lidar has no fault; each way of failing has its own."""

import msgspec
import numpy as np
import pytest

from vehicle_agent.lidar.plausibility import cloud_faults
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud


def a_scan(seed: int = 1, stamp_ns: int = 0) -> PointCloud:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-20.0, 20.0, (500, 3))
    return point_cloud(
        stamp_ns, points, rng.integers(0, 100, 500), rng.integers(0, 16, 500), np.linspace(0, 1e8, 500)
    )


def changed(**values: object) -> PointCloud:
    return msgspec.structs.replace(a_scan(stamp_ns=100), **values)


def holes() -> np.ndarray:
    points = a_scan().points_sensor.copy()
    points[7, 1] = np.nan
    points[9, 2] = np.inf
    return points


@pytest.mark.parametrize(
    ("cloud", "codes"),
    [
        (changed(), []),
        (point_cloud(100, np.zeros((0, 3))), ["empty"]),
        (point_cloud(100, np.ones((20, 3))), ["empty"]),
        (changed(points_sensor=holes()), ["not_finite"]),
        (changed(points_sensor=a_scan(2).points_sensor), ["frozen"]),
        (changed(intensities=np.full(500, 255.0, dtype=np.float32)), ["saturated"]),
        (changed(intensities=np.zeros(500, dtype=np.float32)), []),
        (changed(points_sensor=0.01 * a_scan().points_sensor), ["too_near"]),
        (changed(stamp_ns=0), ["stamp_not_later"]),
        (changed(offsets_ns=a_scan().offsets_ns - 1), ["times_unordered"]),
        (changed(offsets_ns=20 * a_scan().offsets_ns), ["times_unordered"]),
    ],
)
def test_each_way_of_failing_has_its_code(cloud: PointCloud, codes: list[str]) -> None:
    assert [fault.code for fault in cloud_faults(cloud, a_scan(2))] == codes
