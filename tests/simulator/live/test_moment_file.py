"""What moves in the world, as a process beside the simulator reads it."""

import struct
from pathlib import Path

import numpy as np
import pytest

from simulator.live.moment_file import BODIES_MAX, Moment, MomentFile, moment_path
from simulator.traffic.actors import Bodies
from vehicle_agent.device_feed import DeviceFeedError


def a_moment(stamp_ns: int, vehicles: int = 2, count: int = 3) -> Moment:
    rng = np.random.default_rng(stamp_ns)
    bodies = Bodies(
        np.arange(count) + 7, np.arange(count) % 4, rng.normal(0.0, 300.0, (count, 3)),
        rng.normal(0.0, 1.0, (count, 2)), rng.uniform(0.4, 4.0, (count, 2)),
    )  # fmt: skip
    return Moment(stamp_ns, rng.normal(0.0, 300.0, (vehicles, 3)), bodies)


def test_the_newest_moment_is_read_to_the_bit(tmp_path: Path) -> None:
    path = moment_path(tmp_path)
    written = MomentFile(path, create=True)
    read = MomentFile(path, create=False)
    assert read.read() is None, "before the first one"
    for stamp_ns, count in ((10, 3), (20, 40), (30, 0)):
        moment = a_moment(stamp_ns, count=count)
        written.write(moment)
        found = read.read()
        assert found is not None
        assert found.stamp_ns == stamp_ns
        np.testing.assert_array_equal(found.poses_map, moment.poses_map)
        for name in ("numbers", "kinds", "poses_map", "velocities_map_mps", "sizes_m"):
            np.testing.assert_array_equal(getattr(found.bodies, name), getattr(moment.bodies, name))


def test_a_moment_that_is_being_written_is_not_read(tmp_path: Path) -> None:
    path = moment_path(tmp_path)
    MomentFile(path, create=True).write(a_moment(10))
    read = MomentFile(path, create=False)
    with path.open("r+b") as file:
        file.write(struct.pack("<q", 3))
    assert read.read() is None


def test_what_is_read_stays_when_the_next_one_is_written(tmp_path: Path) -> None:
    path = moment_path(tmp_path)
    written, read = MomentFile(path, create=True), MomentFile(path, create=False)
    first = a_moment(10)
    written.write(first)
    found = read.read()
    written.write(a_moment(20))
    assert found is not None
    np.testing.assert_array_equal(found.bodies.poses_map, first.bodies.poses_map)


def test_too_many_road_users_are_cut_and_too_many_vehicles_refused(tmp_path: Path) -> None:
    written = MomentFile(moment_path(tmp_path), create=True)
    written.write(a_moment(10, count=BODIES_MAX + 5))
    found = MomentFile(moment_path(tmp_path), create=False).read()
    assert found is not None
    assert len(found.bodies.numbers) == BODIES_MAX
    with pytest.raises(ValueError, match="at most 1000 vehicles"):
        written.write(a_moment(20, vehicles=1001))


def test_without_a_simulator_there_is_no_moment(tmp_path: Path) -> None:
    with pytest.raises(DeviceFeedError, match="start the simulator first"):
        MomentFile(moment_path(tmp_path), create=False)
