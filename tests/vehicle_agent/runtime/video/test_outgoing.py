"""What leaves the vehicle: what operators asked for, and no face where the policy forbids it."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.video import SegmentName
from vehicle_agent.runtime.video.outgoing import Outgoing
from vehicle_agent.runtime.video.segment_file import SegmentFile
from vehicle_agent.runtime.video.wanted_spans import (
    AFTER_MARK_NS,
    BEFORE_MARK_NS,
    SPANS_MAX,
    VideoMark,
    WantedSpan,
    wanted,
    with_mark,
)

S = 1_000_000_000
MARKS = st.builds(
    VideoMark,
    st.sampled_from(["mark", "start_recording", "stop_recording"]),
    st.integers(0, 10_000 * S),
    st.uuids().map(str),
)


def segment(from_s: int, to_s: int, camera: str = "front") -> SegmentName:
    return SegmentName(camera, from_s * S, from_s * S, (to_s - from_s) * 1000)


@given(st.lists(MARKS, max_size=20))
def test_marks_said_twice_change_nothing(marks: list[VideoMark]) -> None:
    spans: tuple[WantedSpan, ...] = ()
    for mark in marks:
        spans = with_mark(spans, mark)
        if mark.kind != "stop_recording":
            assert with_mark(spans, mark) == spans
        assert len(spans) <= SPANS_MAX
    assert all(span.to_ns is None or span.to_ns >= span.from_ns for span in spans)


@given(st.integers(100 * S, 10_000 * S), st.integers(0, 10_000), st.integers(1, 300))
def test_a_mark_wants_what_was_just_before_and_after_it(at_ns: int, from_s: int, length_s: int) -> None:
    spans = with_mark((), VideoMark("mark", at_ns, "m"))
    name = segment(from_s, from_s + length_s)
    touches = name.utc_ns <= at_ns + AFTER_MARK_NS and name.end_utc_ns >= at_ns - BEFORE_MARK_NS
    assert wanted([name], spans) == ([name] if touches else [])


def test_a_recording_wants_what_lies_between_its_ends() -> None:
    spans = with_mark((), VideoMark("start_recording", 100 * S, "a"))
    assert wanted([segment(0, 60), segment(60, 120), segment(900, 960)], spans) == [
        segment(60, 120),
        segment(900, 960),
    ]
    spans = with_mark(spans, VideoMark("stop_recording", 130 * S, "b"))
    names = [segment(0, 60), segment(60, 120), segment(120, 180), segment(900, 960)]
    assert wanted(names, spans) == names[1:3]


def test_a_recording_that_was_forgotten_ends_after_an_hour() -> None:
    spans = with_mark((), VideoMark("start_recording", 0, "a"))
    assert wanted([segment(3590, 3650), segment(3660, 3720)], spans) == [segment(3590, 3650)]


def lines(folder: Path, name: SegmentName) -> Any:
    """Upright lines of 4 px, as the strokes of a plate near by. The one picture that was recorded."""
    av = pytest.importorskip("av", reason="PyAV is not installed (make video)")
    pixels = np.full((240, 320, 3), 40, np.uint8)
    pixels[80:160, 60:260] = np.where(np.arange(200) // 4 % 2, 220, 20).astype(np.uint8)[None, :, None]
    file = SegmentFile(folder, name, (320, 240), 10.0, 800)
    for number in range(5):
        frame = av.VideoFrame.from_ndarray(pixels, format="rgb24").reformat(format="yuv420p")
        file.add(name.stamp_ns + number * 100_000_000, frame)
    return file.close()


def contrast(path: Path) -> float:
    av = pytest.importorskip("av")
    with av.open(str(path)) as container:
        pictures = [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]
    assert len(pictures) == 5
    return float(np.abs(np.diff(pictures[-1][90:150, 80:240].astype(float), axis=1)).max())


def test_what_leaves_is_so_coarse_that_no_stroke_of_a_plate_is_left(tmp_path: Path) -> None:
    path = lines(tmp_path, segment(100, 101))
    outgoing = Outgoing(tmp_path, "all", "whole")
    assert outgoing.prepare() == segment(100, 100) or outgoing.prepare() is None
    (copy,) = (tmp_path / "outgoing").iterdir()
    assert copy.name == path.name
    assert contrast(path) > 60.0
    assert contrast(copy) < 12.0


def test_only_what_was_asked_for_leaves_and_once(tmp_path: Path) -> None:
    for from_s in (0, 60, 120):
        (tmp_path / segment(from_s, from_s + 59).text()).write_bytes(b"x")
    outgoing = Outgoing(tmp_path, "asked", "none")
    assert outgoing.prepare() is None
    outgoing.note(VideoMark("mark", 90 * S, "m"))
    assert outgoing.prepare() == segment(60, 119)
    (tmp_path / "outgoing" / segment(60, 119).text()).unlink()
    assert Outgoing(tmp_path, "asked", "none").prepare() is None
    assert [file.name for file in (tmp_path / "outgoing").iterdir()] == []


def test_a_segment_that_cannot_be_coarsened_stays(tmp_path: Path) -> None:
    pytest.importorskip("av", reason="PyAV is not installed (make video)")
    (tmp_path / segment(0, 59).text()).write_bytes(b"no video" * 100)
    assert Outgoing(tmp_path, "all", "whole").prepare() == segment(0, 59)
    assert list((tmp_path / "outgoing").iterdir()) == []


def test_by_the_policy_never_nothing_leaves(tmp_path: Path) -> None:
    (tmp_path / segment(0, 59).text()).write_bytes(b"x")
    outgoing = Outgoing(tmp_path, "never", "none")
    outgoing.note(VideoMark("mark", 30 * S, "m"))
    assert outgoing.prepare() is None
    assert list((tmp_path / "outgoing").iterdir()) == []
