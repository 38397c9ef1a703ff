"""Each fault of a simulated lidar is one that the vehicle's check of scans notices by that name."""

import numpy as np
import pytest

from simulator.sensors.lidars.faults import FaultyLidar, LidarFault
from simulator.sensors.lidars.mounts import roof_lidar
from simulator.sensors.lidars.spinning_lidar import SpinningLidar
from simulator.sensors.scene.static_scene import StaticScene
from tests.simulator.sensors.lidars.drives import moving
from tests.simulator.sensors.scene.campus import a_street
from vehicle_agent.config import Body
from vehicle_agent.lidar.plausibility import cloud_faults

PERIOD_NS = 100_000_000


@pytest.fixture
def lidar() -> FaultyLidar:
    return FaultyLidar(
        SpinningLidar(roof_lidar(Body()), StaticScene(a_street(), 3), np.random.default_rng(1))
    )


@pytest.mark.parametrize("fault", ["frozen", "saturated", "not_finite"])
def test_fault_is_noticed_and_ends_with_it(lidar: FaultyLidar, fault: LidarFault) -> None:
    before = lidar.scan(moving(2.0), 0)
    lidar.fault = fault
    during = lidar.scan(moving(2.0), PERIOD_NS)
    lidar.fault = None
    after = lidar.scan(moving(2.0), 2 * PERIOD_NS)
    assert before is not None
    assert during is not None
    assert after is not None
    assert [found.code for found in cloud_faults(during.cloud, before.cloud)] == [fault]
    assert cloud_faults(after.cloud, during.cloud) == ()


def test_dead_lidar_gives_no_scan(lidar: FaultyLidar) -> None:
    lidar.fault = "dead"
    assert lidar.scan(moving(2.0), 0) is None


def test_lidar_that_freezes_before_its_first_scan_repeats_its_first(lidar: FaultyLidar) -> None:
    lidar.fault = "frozen"
    first, second = lidar.scan(moving(2.0), 0), lidar.scan(moving(2.0), PERIOD_NS)
    assert first is not None
    assert second is not None
    assert np.array_equal(first.cloud.points_sensor, second.cloud.points_sensor)
    assert second.cloud.stamp_ns == PERIOD_NS
