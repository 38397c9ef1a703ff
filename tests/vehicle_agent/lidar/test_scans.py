"""Packets become whole scans, each block in one of them; what comes wrong is counted by code."""

import numpy as np
import pytest

from tests.vehicle_agent.lidar.packet_bytes import hesai_packets, square_room, velodyne_packets
from vehicle_agent.lidar.models import VLP16, XT16
from vehicle_agent.lidar.scans import ScanAssembler
from vehicle_agent.signals.point_cloud import PointCloud

# An XT16 sends 250 packets a turn, a VLP-16 75.35.
XT_PACKETS = hesai_packets(XT16, 600, square_room(5.0), begin_cdeg=9_000)


def scans_of(packets: list[tuple[int, bytes]], assembler: ScanAssembler) -> list[PointCloud]:
    found = [assembler.add(stamp_ns, data) for stamp_ns, data in packets]
    return [cloud for cloud in [*found, assembler.finish()] if cloud is not None]


@pytest.mark.parametrize("cut_deg", [0.0, 123.4, 359.9])
def test_every_block_is_in_one_scan_and_whole_scans_are_whole_turns(cut_deg: float) -> None:
    scans = scans_of(XT_PACKETS, ScanAssembler(cut_deg=cut_deg))
    assert sum(map(len, scans)) == 600 * 8 * 16
    assert len(scans) == 4 if cut_deg == 123.4 else len(scans) == 3
    whole = scans[1]
    assert len(whole) == 2_000 * 16
    assert np.diff(whole.offsets_ns).min() >= -50_000
    assert whole.offsets_ns.max() == pytest.approx(1e8, abs=60_000)
    azimuths = np.degrees(np.arctan2(whole.points_sensor[:, 0], whole.points_sensor[:, 1])) % 360.0
    assert (azimuths[0] - cut_deg) % 360.0 == pytest.approx(0.18, abs=0.1001)


def test_stamps_of_packets_that_come_in_bursts_follow_the_sensors_clock() -> None:
    bursts = [(40_000_000 * (stamp_ns // 40_000_000), data) for stamp_ns, data in XT_PACKETS]
    even, burst = (scans_of(packets, ScanAssembler())[1] for packets in (XT_PACKETS, bursts))
    assert np.array_equal(even.offsets_ns, burst.offsets_ns)


def test_the_scan_over_the_full_hour_has_times_in_order() -> None:
    packets = velodyne_packets(VLP16, 200, square_room(5.0), begin_us=3_599_950_000)
    scans = scans_of(packets, ScanAssembler())
    assert all(np.diff(cloud.offsets_ns).min() >= 0 for cloud in scans)
    assert scans[1].offsets_ns.max() == pytest.approx(1e8, rel=0.01)


def test_a_late_packet_is_refused_and_a_clock_that_was_set_is_followed() -> None:
    assembler = ScanAssembler()
    shuffled = [*XT_PACKETS[:100], XT_PACKETS[98], *XT_PACKETS[100:]]
    scans = scans_of(shuffled, assembler)
    assert assembler.refused == {"late_packet": 1}
    assert sum(map(len, scans)) == 600 * 8 * 16
    data = XT_PACKETS[100][1]
    an_hour_ago = data[:556] + bytes((data[556] - 1,)) + data[557:]
    assembler = ScanAssembler()
    scans_of([*XT_PACKETS[:100], (XT_PACKETS[100][0], an_hour_ago)], assembler)
    assert assembler.refused == {}


def test_cut_packets_and_those_of_another_sensor_are_counted_and_left_out() -> None:
    assembler = ScanAssembler()
    stranger = velodyne_packets(VLP16, 1, square_room(5.0))[0]
    mixed = [*XT_PACKETS[:50], (0, b"\xee\xff\x06"), stranger, (0, XT_PACKETS[50][1][:300]), *XT_PACKETS[50:]]
    scans = scans_of(mixed, assembler)
    assert assembler.refused == {"cut_packet": 2, "other_model": 1}
    assert sum(map(len, scans)) == 600 * 8 * 16


def test_a_sensor_that_does_not_turn_fills_no_memory() -> None:
    assembler = ScanAssembler()
    stamp_ns, data = XT_PACKETS[0]
    for _ in range(4_001):
        assert assembler.add(stamp_ns, data) is None
    assert assembler.refused == {"bad_azimuth": 1}


@pytest.mark.parametrize("packets", [XT_PACKETS, velodyne_packets(VLP16, 200, square_room(5.0))])
def test_packets_that_are_read_together_give_the_same_scans(packets: list[tuple[int, bytes]]) -> None:
    """However they are cut into bursts, with noise between them, and stamped with the last one's arrival."""
    singly = scans_of(packets, ScanAssembler())
    assembler, scans = ScanAssembler(), []
    noise = [b"", b"\xee\xff\x06", packets[0][1][:300]]
    for at in range(0, len(packets), 7):
        burst = packets[at : at + 7]
        data = [one for _, one in burst]
        scans += assembler.add_burst(burst[-1][0], [*data[:3], *(noise if at % 2 else []), *data[3:]])
    last = assembler.finish()
    assert last is not None
    assert [len(scan) for scan in [*scans, last]] == [len(scan) for scan in singly]
    for one, other in zip([*scans, last], singly, strict=True):
        assert np.array_equal(one.points_sensor, other.points_sensor)
        assert abs(one.stamp_ns - other.stamp_ns) < 2_000
        assert np.abs(one.offsets_ns - other.offsets_ns).max() < 2_000
    assert sum(assembler.refused.values()) == 3 * (len(range(7, len(packets), 14)))
