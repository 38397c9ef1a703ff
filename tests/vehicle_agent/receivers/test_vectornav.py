"""A VectorNav's binary output, of any configuration and in any pieces, becomes samples and positions."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.vehicle_agent.receivers.vectornav_bytes import common, ins, message
from vehicle_agent.receivers.vectornav import InertialReading, VectorNav


def readings_of(data: bytes) -> list[InertialReading]:
    return VectorNav().add(7, data)[0]


def test_a_sample_has_acceleration_rates_and_attitude() -> None:
    [reading] = readings_of(common((0.5, 0.25, -9.75), (0.125, -0.25, 0.5), (90.0, 2.0, -1.0)))
    assert reading.stamp_ns == 7
    assert reading.accel_sensor_mps2.tolist() == [0.5, 0.25, -9.75]
    assert reading.rates_sensor_radps.tolist() == [0.125, -0.25, 0.5]
    assert reading.pitch_rad == pytest.approx(math.radians(2.0))
    assert reading.roll_rad == pytest.approx(math.radians(-1.0))


def test_the_groups_imu_and_attitude_say_the_same() -> None:
    """A published logger of a VN-100 has this header, and messages of this length."""
    payload = struct.pack("<3f3f3fff", 0, 0, 0, 1.0, 2.0, 3.0, 0.25, 0.5, 0.75, 20.0, 101.0)
    payload += struct.pack("<3f9f3f3f", 0.0, 3.0, 4.0, *[0.0] * 9, *[0.0] * 3, *[0.0] * 3)
    data = message(0x14, [0x003E, 0x003A], payload)
    assert data[:6].hex() == "fa143e003a00"
    assert len(data) == 124
    [reading] = readings_of(data)
    assert reading.accel_sensor_mps2.tolist() == [1.0, 2.0, 3.0]
    assert reading.rates_sensor_radps.tolist() == [0.25, 0.5, 0.75]
    assert reading.pitch_rad == pytest.approx(math.radians(3.0))


def test_a_position_comes_with_the_deviation_that_the_sensor_states() -> None:
    gps_ns = 1_461_931_218_000_000_000
    readings, [solution] = VectorNav().add(0, ins(31.315, 121.39, 3.0, 4.0, 53.13, 0.031, gps_ns=gps_ns))
    assert readings == []
    assert (solution.latitude_deg, solution.longitude_deg) == (31.315, 121.39)
    assert solution.speed_mps == pytest.approx(5.0)
    assert solution.course_rad == pytest.approx(math.atan2(4.0, 3.0))
    assert solution.heading_rad == pytest.approx(math.radians(53.13), abs=1e-6)
    assert solution.position_std_m == pytest.approx(0.031)
    # 2026-05-04 12:00:00 UTC, which GPS counts 18 s later.
    assert solution.utc_ns == 1_777_896_000_000_000_000


@pytest.mark.parametrize("mode", [0, 1])
def test_a_sensor_that_is_not_aligned_gives_no_position(mode: int) -> None:
    assert VectorNav().add(0, ins(31.3, 121.4, 0.0, 0.0, 0.0, mode=mode)) == ([], [])


@given(
    st.lists(st.integers(1, 40), max_size=30),
    st.lists(st.binary(max_size=30).filter(lambda noise: b"\xfa" not in noise), min_size=4, max_size=4),
)
def test_pieces_and_what_lies_between_messages_change_nothing(cuts: list[int], noise: list[bytes]) -> None:
    data = b"".join(between + common((float(n), 0.0, -9.5)) for n, between in enumerate(noise))
    sensor, found, at = VectorNav(), [], 0
    for cut in [*cuts, len(data)]:
        found += sensor.add(0, data[at : at + cut])[0]
        at += cut
    assert [reading.accel_sensor_mps2[0] for reading in found] == [0.0, 1.0, 2.0, 3.0]
    assert sensor.skipped == sum(map(len, noise))


@given(st.integers(0, 10_000), st.integers(1, 255))
def test_a_damaged_message_is_counted_and_the_next_one_is_read(at: int, flip: int) -> None:
    damaged = bytearray(common((1.0, 0.0, -9.5)))
    damaged[at % len(damaged)] ^= flip
    sensor = VectorNav()
    # Enough follows for a length that the damage has made longer.
    found = sensor.add(0, bytes(damaged) + common((2.0, 0.0, -9.5)) * 12)[0]
    assert {reading.accel_sensor_mps2[0] for reading in found} == {2.0}
    assert sensor.skipped + sum(sensor.refused.values()) > 0


def test_fields_of_a_firmware_that_is_not_known_are_refused_by_code() -> None:
    sensor = VectorNav()
    unknown = message(0x80, [1], b"\0" * 8)
    sensor.add(0, unknown + common())
    assert sensor.refused["unknown_fields"] >= 1


def test_a_message_without_anything_that_is_needed_is_counted() -> None:
    sensor = VectorNav()
    assert sensor.add(0, message(0x01, [1], struct.pack("<Q", 5))) == ([], [])
    assert sensor.other == 1
