"""A segment's name says camera, time and length; a folder of names is the index."""

from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from contract.video import SegmentName, name_of, overlapping
from vehicle_agent.runtime.video.segment_names import segments_in

NAMES = st.builds(
    SegmentName,
    st.text("az09_", max_size=30).map("a".__add__),
    st.integers(0, 2**62),
    st.integers(0, 2**62),
    st.none() | st.integers(0, 10**9),
)


@given(NAMES)
def test_a_name_is_read_as_it_was_written(name: SegmentName) -> None:
    assert name_of(name.text()) == name


@given(st.text(max_size=40))
def test_other_files_are_no_segments(text: str) -> None:
    found = name_of(text)
    assert found is None or found.text() == text


@given(st.lists(NAMES, max_size=8), st.integers(0, 2**62), st.integers(0, 2**61))
def test_a_moment_is_in_the_segments_that_cover_it(names: list[SegmentName], begin: int, span: int) -> None:
    found = overlapping(names, begin, begin + span)
    for name in names:
        covers = name.length_ms is not None and not (
            name.utc_ns > begin + span or name.utc_ns + name.length_ms * 10**6 < begin
        )
        assert (name in found) == covers


def test_a_folder_is_its_own_index(tmp_path: Path) -> None:
    later, first = SegmentName("front", 7 * 10**9, 9, 5), SegmentName("front", 10**9, 3, 5)
    for name in (later, first, SegmentName("rear", 5, 4)):
        (tmp_path / name.text()).touch()
    (tmp_path / "notes.txt").touch()
    assert segments_in(tmp_path) == [first, later, SegmentName("rear", 5, 4)]
    assert segments_in(tmp_path / "none") == []
