"""Pictures are cut into segments of the run's time: none is in two, and none is longer than it may be."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.runtime.video.segmenter import SegmentRules, SegmentState, Verdict, step

RULES = SegmentRules(5_000_000_000, 2_000_000_000, 100_000_000)


def segments(stamps_ns: list[int]) -> list[list[int]]:
    state, found = SegmentState(), []
    for stamp_ns in stamps_ns:
        verdict, state = step(state, stamp_ns, RULES)
        if verdict is Verdict.BEGIN:
            found.append([stamp_ns])
        elif verdict is Verdict.ADD:
            found[-1].append(stamp_ns)
    return found


@given(st.lists(st.integers(-3 * 10**9, 4 * 10**9), max_size=80), st.integers(0, 10**15))
def test_segments_are_in_order_and_within_one_stretch_of_the_clock(steps: list[int], begin: int) -> None:
    stamps, at = [], begin
    for difference in steps:
        at += difference
        stamps.append(at)
    for segment in segments(stamps):
        assert all(0 < after - before <= RULES.gap_ns for before, after in pairwise(segment))
        assert len({stamp // RULES.length_ns for stamp in segment}) == 1


@given(st.integers(0, 10**15), st.lists(st.integers(-30_000_000, 30_000_000), min_size=5, max_size=100))
def test_no_picture_of_a_camera_at_its_rate_is_left_out(begin: int, jitter: list[int]) -> None:
    stamps = [begin + number * RULES.period_ns + late for number, late in enumerate(jitter)]
    assert sum(map(len, segments(stamps))) == len(stamps)


@pytest.mark.parametrize("rate_hz", [25.0, 29.97, 30.0, 60.0])
def test_of_a_faster_camera_ten_pictures_a_second_are_kept(rate_hz: float) -> None:
    stamps = [round(number * 1e9 / rate_hz) for number in range(round(60 * rate_hz))]
    assert sum(map(len, segments(stamps))) == pytest.approx(600, abs=3)


def test_segments_of_two_cameras_begin_together() -> None:
    first = segments([number * 100_000_000 for number in range(200)])
    other = segments([37_000_000 + number * 100_000_000 for number in range(200)])
    assert [one[0] // RULES.length_ns for one in first] == [one[0] // RULES.length_ns for one in other]


def test_a_camera_that_was_away_begins_a_segment() -> None:
    assert [len(one) for one in segments([0, 10**8, 3 * 10**9, 31 * 10**8])] == [2, 2]
