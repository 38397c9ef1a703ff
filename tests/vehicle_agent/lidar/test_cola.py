"""Telegrams of planar scanners become turns; broken ones are named, and cost nothing else."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.vehicle_agent.lidar.sick_telegrams import PUBLISHED, telegram
from vehicle_agent.lidar.cola import (
    PlanarTurn,
    ScannerRefusal,
    TelegramError,
    TelegramReader,
    turn_of,
)


def turn(data: bytes) -> PlanarTurn:
    (whole,) = TelegramReader().add(data)
    found = turn_of(whole)
    assert found is not None
    return found


def test_the_published_telegram_is_what_its_listing_says() -> None:
    found = turn_of(PUBLISHED)
    assert found is not None
    assert found.ranges_m[[0, -1]] == pytest.approx([2.209, 2.310])
    # 10 to 20 degrees from the scanner's right: 80 to 70 degrees right of straight ahead.
    assert np.degrees(found.angles_rad[[0, -1]]) == pytest.approx([-80.0, -70.0])
    assert (len(found.ranges_m), found.counter, found.status) == (21, 0x343, "")
    assert found.age_s == pytest.approx(0.001426)


def test_a_whole_turn_goes_from_right_to_left_and_its_middle_beam_has_its_stamp() -> None:
    found = turn(telegram([4_000] * 541, intensities=range(541)))
    assert np.degrees(found.angles_rad[[0, 270, -1]]) == pytest.approx([-135.0, 0.0, 135.0])
    # 270 degrees at 50 turns a second.
    assert found.offsets_s[[0, 270, -1]] == pytest.approx([-0.0075, 0.0, 0.0075])
    assert found.intensities.tolist() == list(range(541))


def test_what_was_not_measured_has_no_range() -> None:
    found = turn(telegram([0, 1, 15, 16, 20_000], scale=2.0))
    assert found.ranges_m.tolist() == [math.inf, math.inf, math.inf, 0.032, 40.0]
    assert found.intensities.tolist() == [0.0] * 5


def test_encoders_before_the_distances_are_passed_over() -> None:
    assert turn(telegram([3_000] * 3, encoders=2)).ranges_m.tolist() == [3.0] * 3


def test_the_scanners_clock_may_begin_again_within_a_turn() -> None:
    assert turn(telegram([3_000], begun_us=(1 << 32) - 5_000)).age_s == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("status", "says"), [(1, "device error"), (2, "pollution warning"), (5, "pollution"), (9, "status 9")]
)
def test_what_the_scanner_says_of_itself_is_kept(status: int, says: str) -> None:
    assert turn(telegram([3_000], status=status)).status == says


@settings(max_examples=60, deadline=None)
@given(data=st.data(), raws=st.lists(st.lists(st.integers(16, 60_000), min_size=1, max_size=6), max_size=4))
def test_a_stream_may_be_cut_anywhere(data: st.DataObject, raws: list[list[int]]) -> None:
    stream = b"".join(telegram(raw, counter=k) for k, raw in enumerate(raws))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=6)))
    reader = TelegramReader()
    parts = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    found = [turn_of(whole) for part in parts for whole in reader.add(part)]
    read = [(one.counter, np.rint(1_000.0 * one.ranges_m).tolist()) for one in found if one is not None]
    assert read == list(enumerate(raws))
    assert reader.refused == {}


def test_noise_between_telegrams_is_counted_and_costs_none() -> None:
    reader = TelegramReader()
    found = reader.add(b"hello\x03" + b"xx" + telegram([3_000]) + b"\x02sSN LMD" + telegram([4_000]))
    assert [turn_of(one) is not None for one in found] == [True, True]
    assert reader.refused == {"noise": 3}


def test_what_never_ends_is_dropped() -> None:
    reader = TelegramReader()
    for _ in range(80):
        assert reader.add(b"\x02" + b"0" * 1_000) == []
    assert reader.refused == {"no_end": 1}
    reader.add(b"\x03")
    assert len(reader.add(telegram([3_000]))) == 1


def test_an_answer_is_no_turn_and_a_refusal_says_which() -> None:
    assert turn_of(b"sEA LMDscandata 1") is None
    assert turn_of(b"") is None
    with pytest.raises(ScannerRefusal, match="sFA 3"):
        turn_of(b"sFA 3")


GOOD = telegram([3_000] * 4)[1:-1]


@pytest.mark.parametrize(
    ("broken", "code"),
    [
        (GOOD[:60], "cut_short"),
        (GOOD.replace(b"DIST1", b"DIST2"), "no_distances"),
        (GOOD.replace(b" BB8 ", b" BX8 ", 1), "bad_number"),
        (GOOD.replace(b"3F800000", b"7F800000"), "bad_number"),
        (GOOD.replace(b"3F800000", b"BF800000"), "bad_number"),
        (GOOD.replace(b"3F800000", b"+nan"), "bad_number"),
        (GOOD.replace(b" 1388 4 ", b" 0 4 "), "bad_geometry"),
        (GOOD.replace(b" 1388 4 ", b" FFFF 7FFFFFFF "), "bad_geometry"),
        (GOOD.replace(b"FFF92230", b"6FFFFFFF"), "bad_geometry"),
        (GOOD.replace(b" 0 1388 168 ", b" 0 0 168 "), "bad_geometry"),
        (GOOD.replace(b"DIST1", b"DIST\xff"), "bad_number"),
    ],
)
def test_a_broken_turn_is_refused_by_its_code(broken: bytes, code: str) -> None:
    assert broken != GOOD
    with pytest.raises(TelegramError) as refused:
        turn_of(broken)
    assert refused.value.code == code


@settings(max_examples=300, deadline=None)
@given(where=st.integers(0, len(GOOD) - 1), byte=st.integers(0, 255))
def test_a_byte_that_was_changed_gives_a_turn_or_a_code(where: int, byte: int) -> None:
    changed = GOOD[:where] + bytes([byte]) + GOOD[where + 1 :]
    try:
        found = turn_of(changed)
    except TelegramError:
        return
    if found is not None:
        assert len(found.ranges_m) == len(found.angles_rad) == len(found.offsets_s) == len(found.intensities)
        assert np.isfinite(found.angles_rad).all()
        assert (found.ranges_m > 0.0).all()
