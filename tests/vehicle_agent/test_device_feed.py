from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.device_feed import (
    POINTS_MAX,
    SLOTS,
    DatagramPort,
    DeviceFeedError,
    DeviceOutputs,
    DeviceSensors,
    DeviceValues,
    ScanReady,
    ScanRing,
)
from vehicle_agent.signals import CodeTyped, DoorState, GnssFix, HmiOutput, ImuSample, SeatButton, SeatSensor

VALUES = (
    GnssFix(1, 31.3, 121.4, 0.5, 2.0, 0.1, 0.02),
    ImuSample(2, 0.3, 0.1),
    DoorState(3, True),
    SeatSensor(4, 2),
    SeatButton(5, 1),
    CodeTyped(6, "4711"),
)


def a_scan(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.random((count, 3), dtype=np.float32), rng.random(count, dtype=np.float32)


def test_every_kind_of_value_arrives_as_it_was_sent() -> None:
    sensors = DeviceSensors(0)
    sender = DatagramPort()
    sender.send(sensors._port.port, DeviceValues(VALUES))
    assert sensors.poll() == [("sensors", value) for value in VALUES]
    assert sensors.poll() == []
    sensors.close()
    sender.close()


def test_words_go_the_other_way() -> None:
    device, computer = DatagramPort(), DatagramPort()
    words = DeviceOutputs(HmiOutput("Please step aside", "请让一让", "", "", False))
    computer.send(device.port, words)
    assert device.take() == [words]
    device.close()
    computer.close()


def test_a_datagram_that_is_not_ours_is_counted_and_dropped() -> None:
    port, other = DatagramPort(), DatagramPort()
    other._socket.sendto(b"\xc1 nonsense", ("127.0.0.1", port.port))
    other.send(port.port, DeviceValues(VALUES))
    assert port.take() == [DeviceValues(VALUES)]
    assert port.malformed == 1
    port.close()
    other.close()


def test_a_computer_that_is_gone_does_not_stop_the_devices() -> None:
    gone = DatagramPort()
    number = gone.port
    gone.close()
    sender = DatagramPort()
    for _ in range(5):
        sender.send(number, DeviceValues(VALUES))
        assert sender.take() == []
    back = DatagramPort(number)
    sender.send(number, DeviceValues(VALUES))
    assert back.take() == [DeviceValues(VALUES)]
    back.close()
    sender.close()


def test_a_taken_port_is_refused_with_what_to_do() -> None:
    port = DatagramPort()
    with pytest.raises(DeviceFeedError, match="--base-port"):
        DatagramPort(port.port)
    port.close()


@given(st.integers(0, 20_000))
def test_a_scan_comes_back_bit_for_bit(count: int) -> None:
    points, intensities = a_scan(count)
    ring = _RING[0]
    read = ring.read(ring.write(count, 5, points, intensities))
    assert read is not None
    assert np.array_equal(read[0], points)
    assert np.array_equal(read[1], intensities)


def test_reader_and_writer_share_the_file(tmp_path: Path) -> None:
    writer = ScanRing(tmp_path / "s1.scans", create=True)
    reader = ScanRing(tmp_path / "s1.scans", create=False)
    points, intensities = a_scan(1000)
    ready = writer.write(0, 77, points, intensities)
    read = reader.read(ready)
    assert read is not None
    assert np.array_equal(read[0], points)


def test_a_driver_that_starts_again_serves_the_readers_it_had(tmp_path: Path) -> None:
    first = ScanRing(tmp_path / "s1.scans", create=True)
    old = first.write(0, 1, *a_scan(10))
    reader = ScanRing(tmp_path / "s1.scans", create=False)
    second = ScanRing(tmp_path / "s1.scans", create=True)
    assert reader.read(old) is None
    points, intensities = a_scan(20, 2)
    read = reader.read(second.write(0, 9, points, intensities))
    assert read is not None
    assert np.array_equal(read[0], points)


def test_a_scan_that_was_overwritten_is_not_read_as_another(tmp_path: Path) -> None:
    ring = ScanRing(tmp_path / "s1.scans", create=True)
    old = ring.write(0, 1, *a_scan(10))
    for number in range(1, SLOTS + 1):
        ring.write(number, number + 1, *a_scan(10, number))
    assert ring.read(old) is None
    assert ring.read(ScanReady(SLOTS, SLOTS + 1)) is not None


def test_four_lidars_fit_into_a_slot(tmp_path: Path) -> None:
    ring = ScanRing(tmp_path / "s1.scans", create=True)
    ready = ring.write(0, 1, *a_scan(4 * 32_000))
    read = ring.read(ready)
    assert read is not None
    assert len(read[0]) == 4 * 32_000
    assert ready.left_out == 0


def test_of_more_points_than_a_slot_holds_some_of_each_side_are_left_out_and_it_is_said(
    tmp_path: Path,
) -> None:
    ring = ScanRing(tmp_path / "s1.scans", create=True)
    points, intensities = a_scan(POINTS_MAX + 5_000)
    ready = ring.write(0, 1, points, intensities)
    read = ring.read(ready)
    assert read is not None
    assert len(read[0]) == POINTS_MAX
    assert ready.left_out == 5_000
    # The last points are of another side than the first.
    assert np.array_equal(read[0][0], points[0])
    kept_of_last = np.isin(points[-1_000:, 0], read[0][:, 0])
    assert 0.9 < kept_of_last.mean() < 1.0


def test_a_missing_ring_is_refused_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(DeviceFeedError, match="driver first"):
        ScanRing(tmp_path / "none.scans", create=False)


@pytest.fixture(autouse=True, scope="module")
def _ring(tmp_path_factory: pytest.TempPathFactory) -> None:
    _RING[:] = [ScanRing(tmp_path_factory.mktemp("ring") / "shared.scans", create=True)]


_RING: list[ScanRing] = []
