"""Packets of known rooms give points on their walls; packets that say nothing are refused by code."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.vehicle_agent.lidar.packet_bytes import NOON, hesai_packets, square_room, velodyne_packets
from vehicle_agent.lidar.clouds import cloud_of
from vehicle_agent.lidar.decoding import decode_packets, model_of
from vehicle_agent.lidar.models import MODELS, VELODYNE, VLP16, XT16, LidarModel
from vehicle_agent.lidar.packets import PACKET_CODES, PacketError
from vehicle_agent.signals.point_cloud import PointCloud

ROOM_M = 8.0


def packets_of(model: LidarModel, count: int, dual: bool = False) -> list[tuple[int, bytes]]:
    room = square_room(ROOM_M)
    if model.maker == VELODYNE:
        return velodyne_packets(model, count, room, dual=dual)
    return hesai_packets(model, count, room, dual=dual)


def decoded(packets: list[tuple[int, bytes]]) -> PointCloud:
    data = [packet for _, packet in packets]
    values = decode_packets(data, model_of(data[0]))
    stamps_ns = np.array([stamp for stamp, _ in packets])
    return cloud_of(values, stamps_ns, np.ones(values.azimuths_cdeg.shape, dtype=bool))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_returns_of_a_square_room_lie_on_its_walls(model: LidarModel) -> None:
    cloud = decoded(packets_of(model, 20))
    assert model_of(packets_of(model, 1)[0][1]) is model
    walls_m = np.abs(cloud.points_sensor[:, :2]).max(axis=1)
    # Half a unit of distance, and half a hundredth of a degree of a wall that is met slantingly.
    assert np.abs(walls_m - ROOM_M).max() < 0.5 * model.distance_m + 0.003
    elevations = np.arcsin(cloud.points_sensor[:, 2] / np.linalg.norm(cloud.points_sensor, axis=1))
    assert elevations == pytest.approx(np.sort(model.elevations_rad)[cloud.rings], abs=1e-5)
    assert set(np.unique(cloud.intensities)) == set(range(10, 26))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_offsets_follow_the_turn_of_the_sensor(model: LidarModel) -> None:
    cloud = decoded(packets_of(model, 20))
    x, y = cloud.points_sensor[:, 0], cloud.points_sensor[:, 1]
    turn = np.arctan2(-y, x) if model.maker == VELODYNE else np.arctan2(x, y)
    beams = {ring: model.azimuths_rad[unit] for unit, ring in enumerate(model.rings.tolist())}
    turn = np.unwrap((turn - np.array([beams[ring] for ring in cloud.rings.tolist()])) % (2 * np.pi))
    turned_ns = 1e8 * turn / (2 * np.pi)
    # A hundredth of a degree is 2.8 us. A Hesai states one azimuth for all beams of a block, which fire one
    # after the other.
    slack_ns = 6_000 if model.maker == VELODYNE else model.sequence_ns + 30_000
    late_ns = cloud.offsets_ns - turned_ns
    assert np.ptp(late_ns) < slack_ns


@pytest.mark.parametrize("model", [VLP16, XT16], ids=["VLP-16", "XT16"])
def test_the_second_of_two_equal_returns_is_left_out(model: LidarModel) -> None:
    """In dual-return mode a packet covers half the turn, so two make one."""
    twice, once = decoded(packets_of(model, 12, dual=True)), decoded(packets_of(model, 6))
    assert len(twice) == len(once)
    assert np.abs(twice.points_sensor - once.points_sensor).max() < 0.005
    assert np.abs(twice.offsets_ns - once.offsets_ns).max() < 1_000


def test_a_hesai_states_the_date_and_a_velodyne_the_time_in_the_hour() -> None:
    hesai = [data for _, data in hesai_packets(XT16, 2, square_room(ROOM_M))]
    values = decode_packets(hesai, XT16)
    assert values.sensor_ns.tolist() == [int(NOON.timestamp()) * 10**9 + k * 400_000 for k in (1, 2)]
    velodyne = [data for _, data in velodyne_packets(VLP16, 2, square_room(ROOM_M), begin_us=3_599_999_999)]
    values = decode_packets(velodyne, VLP16)
    assert values.sensor_ns.tolist() == [3_599_999_999_000, 1_326_000]
    assert values.sensor_time_period_ns == 3_600_000_000_000


def _changed(data: bytes, at: int, value: bytes) -> bytes:
    return data[:at] + value + data[at + len(value) :]


VELODYNE_PACKET = packets_of(VLP16, 1)[0][1]
XT_PACKET = packets_of(XT16, 1)[0][1]


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", "unknown_model"),
        (VELODYNE_PACKET[:-1], "unknown_model"),
        (_changed(VELODYNE_PACKET, 1205, b"\x63"), "unknown_model"),
        (_changed(VELODYNE_PACKET, 100, b"\x00"), "bad_block"),
        (_changed(VELODYNE_PACKET, 2, b"\xa0\x8c"), "bad_azimuth"),
        (XT_PACKET[:-1], "cut_packet"),
        (XT_PACKET + b"\x00", "cut_packet"),
        (XT_PACKET[:5], "cut_packet"),
        (_changed(XT_PACKET, 6, b"\x11"), "unknown_model"),
        (_changed(XT_PACKET, 12, b"\xff\xff"), "bad_azimuth"),
        (_changed(XT_PACKET, 12 + 8 * 66 + 10, b"\x99"), "unknown_model"),
    ],
)
def test_a_packet_that_says_nothing_is_refused_by_code(data: bytes, code: str) -> None:
    with pytest.raises(PacketError) as refused:
        decode_packets([data], model_of(data))
    assert refused.value.code == code


@given(
    st.binary(max_size=1300)
    | st.binary(min_size=4, max_size=600).map(lambda tail: b"\xee\xff\x06\x01" + tail)
)
def test_bytes_of_any_kind_are_decoded_or_refused(data: bytes) -> None:
    assert _code(data) in (*PACKET_CODES, "decoded")


def _code(data: bytes) -> str:
    try:
        decode_packets([data], model_of(data))
    except PacketError as error:
        return error.code
    return "decoded"


@given(st.lists(st.integers(0, 35_999), min_size=8, max_size=8), st.binary(min_size=6, max_size=6))
def test_whatever_a_whole_packet_holds_its_points_are_finite(azimuths: list[int], date: bytes) -> None:
    data = bytearray(XT_PACKET)
    for block, azimuth in enumerate(azimuths):
        data[12 + 66 * block : 14 + 66 * block] = azimuth.to_bytes(2, "little")
    data[12 + 8 * 66 + 13 : 12 + 8 * 66 + 19] = date
    cloud = decoded([(0, bytes(data))])
    assert np.isfinite(cloud.points_sensor).all()
    assert len(cloud) == 8 * 16
