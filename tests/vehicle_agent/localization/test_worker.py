"""Jobs and scans find each other: a scan is compared from where the vehicle was at its stamp."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Pose2, compose, wrap_angle
from vehicle_agent.localization.worker import GAP_NS_MAX, LocalizationWorker
from vehicle_agent.signals import LocalizationJob, ScanUnplaced
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud

TICK_NS = 20_000_000
MAP_ODOM = Pose2(120.0, -40.0, 2.0)


class Asked:
    """A matcher that only remembers what it was asked."""

    def __init__(self) -> None:
        self.jobs: list[LocalizationJob] = []

    def step(self, cloud: PointCloud, job: LocalizationJob) -> ScanUnplaced:
        self.jobs.append(job)
        return ScanUnplaced(cloud.stamp_ns, "too_little")

    def take_matched(self) -> None:
        return None


def odom_at(stamp_ns: int, speed_mps: float, turn_radps: float) -> Pose2:
    """On a circle, or straight ahead."""
    t = 1e-9 * stamp_ns
    if abs(turn_radps) < 1e-6:
        return Pose2(speed_mps * t, 0.0, 0.0)
    radius_m, angle = speed_mps / turn_radps, turn_radps * t
    return Pose2(radius_m * math.sin(angle), radius_m * (1.0 - math.cos(angle)), wrap_angle(angle))


def a_job(stamp_ns: int, speed_mps: float = 2.0, turn_radps: float = 0.0) -> LocalizationJob:
    odom = odom_at(stamp_ns, speed_mps, turn_radps)
    return LocalizationJob(stamp_ns, compose(MAP_ODOM, odom), odom, np.eye(3), speed_mps, turn_radps)


@given(st.integers(0, 40 * TICK_NS), st.floats(0.0, 4.0), st.floats(-0.6, 0.6))
def test_a_scan_is_compared_from_the_vehicles_place_at_its_stamp(
    stamp_ns: int, speed_mps: float, turn_radps: float
) -> None:
    asked = Asked()
    worker = LocalizationWorker(asked)
    for tick in range(41):
        worker.take(a_job(tick * TICK_NS, speed_mps, turn_radps))
    assert worker.is_ready(stamp_ns)
    assert worker.answer(point_cloud(stamp_ns, np.zeros((1, 3)))) is not None
    (job,) = asked.jobs
    true = compose(MAP_ODOM, odom_at(stamp_ns, speed_mps, turn_radps))
    assert job.stamp_ns == stamp_ns
    assert math.hypot(job.pose_map.x_m - true.x_m, job.pose_map.y_m - true.y_m) < 1e-3
    assert abs(wrap_angle(job.pose_map.yaw_rad - true.yaw_rad)) < 1e-6


def test_a_scan_waits_for_the_job_that_reaches_it() -> None:
    worker = LocalizationWorker(Asked())
    assert not worker.is_ready(0)
    worker.take(a_job(TICK_NS))
    assert not worker.is_ready(TICK_NS + 1)
    worker.take(a_job(2 * TICK_NS))
    assert worker.is_ready(TICK_NS + 1)


def test_a_scan_of_before_the_jobs_is_not_answered() -> None:
    worker = LocalizationWorker(Asked())
    worker.take(a_job(5 * TICK_NS))
    assert worker.answer(point_cloud(4 * TICK_NS, np.zeros((1, 3)))) is None


def test_odometry_of_another_start_of_the_tick_is_not_mixed_in() -> None:
    asked = Asked()
    worker = LocalizationWorker(asked)
    worker.take(a_job(TICK_NS))
    worker.take(a_job(2 * TICK_NS + GAP_NS_MAX))
    assert worker.answer(point_cloud(2 * TICK_NS, np.zeros((1, 3)))) is None
    assert asked.jobs == []
