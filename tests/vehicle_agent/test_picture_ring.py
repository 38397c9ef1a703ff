"""Pictures pass the ring whole and in order; what a slow reader misses is counted."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vehicle_agent.device_feed import DeviceFeedError
from vehicle_agent.picture_ring import SLOTS, PictureRing


def picture(number: int) -> np.ndarray:
    return np.full((4, 6, 3), number % 256, np.uint8)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40, deadline=None)
@given(steps=st.lists(st.integers(0, 3 * SLOTS), max_size=12))
def test_every_picture_is_read_or_counted_as_missed(tmp_path: Path, steps: list[int]) -> None:
    writer = PictureRing(tmp_path / "ring", create=True)
    reader = PictureRing(tmp_path / "ring", create=False)
    written = accounted = 0
    for count in steps:
        for _ in range(count):
            writer.write(written, picture(written))
            written += 1
        while (found := reader.read()) is not None:
            accounted += found.missed + 1
            assert found.stamp_ns == accounted - 1
            assert np.array_equal(found.pixels, picture(found.stamp_ns))
        assert accounted == written
        if count < SLOTS:
            assert found is None
    writer.close()
    reader.close()


def test_a_driver_that_is_started_again_is_followed(tmp_path: Path) -> None:
    writer = PictureRing(tmp_path / "ring", create=True)
    reader = PictureRing(tmp_path / "ring", create=False)
    for number in range(5):
        writer.write(number, picture(number))
    while reader.read() is not None:
        pass
    again = PictureRing(tmp_path / "ring", create=True)
    again.write(100, picture(7))
    found = reader.read()
    assert found is not None
    assert (found.stamp_ns, found.missed) == (100, 0)


def test_without_a_driver_there_is_no_ring(tmp_path: Path) -> None:
    with pytest.raises(DeviceFeedError, match="start the camera's driver"):
        PictureRing(tmp_path / "ring", create=False)
