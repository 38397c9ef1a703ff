"""A receiver's bytes, in whatever pieces they come, become fixes; what is wrong is counted by code."""

import datetime
import itertools
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.receivers.frames import FrameSplitter
from vehicle_agent.receivers.gnss_receiver import GnssReceiver
from vehicle_agent.receivers.solutions import FixTracker, Solution
from vehicle_agent.signals import GnssFix

pynmeagps = pytest.importorskip("pynmeagps", reason="needs the extra `workshop`")
pyubx2 = pytest.importorskip("pyubx2", reason="needs the extra `workshop`")

SECOND_NS = 1_000_000_000
NOON_NS = int(datetime.datetime(2026, 5, 4, 12, tzinfo=datetime.UTC).timestamp()) * SECOND_NS


def sentence(kind: str, **values: Any) -> bytes:
    data: bytes = pynmeagps.NMEAMessage("GN", kind, 0, **values).serialize()
    return data


def epoch(second: int, course_deg: float = 90.0, gst: bool = True, **changes: Any) -> bytes:
    """RMC, GGA and GST of one second after noon, as a receiver sends them."""
    time = datetime.time(12, 0, second)
    place: dict[str, Any] = {"time": time, "lat": 31.315, "NS": "N", "lon": 121.39, "EW": "E"}
    rmc = {**place, "status": "A", "spd": 4.0, "cog": course_deg, "date": datetime.date(2026, 5, 4)}
    gga = {**place, "quality": 1, "numSV": 9, "HDOP": 1.2}
    rmc |= {name: value for name, value in changes.items() if name in ("status", "spd", "cog")}
    gga |= {name: value for name, value in changes.items() if name == "quality"}
    deviations = sentence("GST", time=time, rangeRms=1.0, stdLat=0.012, stdLong=0.018, stdAlt=0.03)
    return sentence("RMC", **rmc) + sentence("GGA", **gga) + (deviations if gst else b"")


def nav_pvt(**changes: Any) -> bytes:
    values: dict[str, Any] = {
        "year": 2026, "month": 5, "day": 4, "hour": 12, "min": 0, "second": 1, "validDate": 1, "validTime": 1,
        "nano": -5, "fixType": 3, "gnssFixOk": 1, "lat": 31.315, "lon": 121.39, "gSpeed": 2000, "hAcc": 15,
        "headMot": 180.0, "headVeh": 0.0, "headVehValid": 0,
    }  # fmt: skip
    data: bytes = pyubx2.UBXMessage("NAV", "NAV-PVT", pyubx2.GET, **(values | changes)).serialize()
    return data


def fixes_of(receiver: GnssReceiver, *parts: bytes) -> list[GnssFix]:
    return [fix for k, part in enumerate(parts) for fix in receiver.add((k + 1) * SECOND_NS, part)]


def test_an_epoch_of_nmea_is_one_fix_with_the_stated_deviation() -> None:
    receiver = GnssReceiver()
    fixes = fixes_of(receiver, epoch(1), epoch(2, course_deg=100.0))
    # The first epoch is given before the receiver is known to send deviations.
    assert [round(fix.position_std_m, 3) for fix in fixes] == [3.0, 0.018]
    fix = fixes[1]
    assert (fix.latitude_deg, fix.longitude_deg) == pytest.approx((31.315, 121.39), abs=1e-7)
    assert fix.speed_mps == pytest.approx(4.0 * 1852.0 / 3600.0)
    assert fix.heading_rad == pytest.approx(math.radians(-10.0))
    assert fix.yaw_rate_radps == pytest.approx(math.radians(-10.0))
    assert receiver.latest is not None
    assert receiver.latest.utc_ns == NOON_NS + 2 * SECOND_NS


def test_without_deviations_those_of_the_dilution_are_taken() -> None:
    fixes = fixes_of(GnssReceiver(), epoch(1, gst=False), epoch(2, gst=False))
    assert [fix.position_std_m for fix in fixes] == pytest.approx([3.0, 3.0])


def test_a_heading_of_two_antennas_goes_before_the_course() -> None:
    receiver = GnssReceiver()
    heading = sentence("HDT", headingT=0.0, headingTi="T")
    (fix,) = fixes_of(receiver, heading + epoch(1, spd=0.0))
    assert fix.heading_rad == pytest.approx(math.pi / 2)


def test_nav_pvt_is_a_fix_by_itself() -> None:
    receiver = GnssReceiver()
    (fix,) = fixes_of(receiver, nav_pvt())
    assert fix.position_std_m == pytest.approx(0.015)
    assert fix.heading_rad == pytest.approx(-math.pi / 2)
    assert fix.speed_mps == pytest.approx(2.0)
    assert receiver.latest is not None
    assert receiver.latest.utc_ns == NOON_NS + SECOND_NS - 5
    (fix,) = fixes_of(GnssReceiver(), nav_pvt(headVeh=90.0, headVehValid=1, gSpeed=0))
    assert fix.heading_rad == pytest.approx(0.0)


def test_a_vehicle_that_has_not_moved_has_no_heading_and_one_that_stops_keeps_it() -> None:
    receiver = GnssReceiver()
    assert fixes_of(receiver, nav_pvt(gSpeed=0)) == []
    assert receiver.fixes.no_heading == 1
    moving, standing = fixes_of(receiver, nav_pvt(gSpeed=1000), nav_pvt(gSpeed=0, headMot=17.0))
    assert standing.heading_rad == moving.heading_rad
    assert standing.yaw_rate_radps == 0.0


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (epoch(1, status="V"), "no_solution"),
        (epoch(1, quality=0), "no_solution"),
        (nav_pvt(gnssFixOk=0), "no_solution"),
        (nav_pvt(fixType=0), "no_solution"),
        (epoch(1).replace(b"31", b"32", 1), "bad_checksum"),
        (b"$GNRMC,,,,,,,,,,,,*00\r\n", "bad_checksum"),
    ],
)
def test_what_gives_no_position_is_counted(data: bytes, code: str) -> None:
    receiver = GnssReceiver()
    assert fixes_of(receiver, data) == []
    assert code in receiver.refused


def test_a_frame_with_a_wrong_checksum_is_counted_and_does_not_hold_back_the_next() -> None:
    receiver = GnssReceiver()
    assert len(fixes_of(receiver, nav_pvt()[:-1] + b"\x00" + nav_pvt())) == 1
    assert receiver.frames.bad_checksums == 1


def test_other_messages_and_noise_are_passed_over() -> None:
    receiver = GnssReceiver()
    status = pyubx2.UBXMessage("NAV", "NAV-STATUS", pyubx2.GET).serialize()
    long_header = b"\xb5\x62\x01\x07\xff\xff"
    fixes = fixes_of(receiver, b"\xff\xb5noise$" + b"\x80" * 3 + status + long_header + nav_pvt())
    assert len(fixes) == 1
    assert receiver.other == 1
    assert receiver.frames.skipped > 10


STREAM = b"noise" + epoch(1) + nav_pvt() + epoch(2) + b"\xb5\x62" + nav_pvt()


@given(st.lists(st.integers(0, len(STREAM)), max_size=12))
def test_messages_are_the_same_in_whatever_pieces_they_come(cuts: list[int]) -> None:
    whole = FrameSplitter().add(STREAM)
    splitter, bounds = FrameSplitter(), [0, *sorted(cuts), len(STREAM)]
    pieces = [STREAM[a:b] for a, b in itertools.pairwise(bounds)]
    assert [frame for piece in pieces for frame in splitter.add(piece)] == whole
    assert len(whole) == 8


@given(st.binary(max_size=400))
def test_no_bytes_stop_a_receiver(noise: bytes) -> None:
    receiver = GnssReceiver()
    receiver.add(1, noise)
    receiver.add(2, b"\r\n" * 200)
    found = fixes_of(receiver, *([b"\n" + nav_pvt()] * 12))
    assert found


def test_fixes_far_apart_tell_no_turn() -> None:
    tracker = FixTracker()
    solution = Solution(None, 31.0, 121.0, 3.0, 0.0, None, 0.5)
    assert tracker.fix(SECOND_NS, solution) is not None
    turned = tracker.fix(9 * SECOND_NS, Solution(None, 31.0, 121.0, 3.0, 1.0, None, 0.5))
    assert turned is not None
    assert turned.yaw_rate_radps == 0.0
