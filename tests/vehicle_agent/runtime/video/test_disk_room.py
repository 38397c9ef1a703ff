"""The oldest segments make room for the newest, and run logs keep theirs."""

from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from contract.video import SegmentName
from vehicle_agent.runtime.video.disk_room import FREE_BYTES_MIN, DiskRoom
from vehicle_agent.runtime.video.segment_names import segments_in


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30, deadline=None)
@given(sizes=st.lists(st.integers(0, 400), max_size=10), keep=st.integers(0, 1500))
def test_the_newest_that_fit_are_kept(tmp_path: Path, sizes: list[int], keep: int) -> None:
    for path in tmp_path.iterdir():
        path.unlink()
    names = [SegmentName("front", n, 10 + n, 1) for n in range(len(sizes))]
    for name, size in zip(names, sizes, strict=True):
        (tmp_path / name.text()).write_bytes(b"x" * size)
    (tmp_path / SegmentName("front", 99, 99).text()).write_bytes(b"open")
    disk = DiskRoom(tmp_path, keep, lambda _: FREE_BYTES_MIN)
    gone = disk.look()
    left = [name for name in segments_in(tmp_path) if name.length_ms is not None]
    assert disk.has_room
    assert left == names[len(gone) :]
    kept = sum(sizes[len(gone) :])
    assert kept <= keep
    assert not gone or kept + sizes[len(gone) - 1] > keep
    assert SegmentName("front", 99, 99) in segments_in(tmp_path)


def test_a_disk_that_others_fill_takes_no_more_video(tmp_path: Path) -> None:
    (tmp_path / SegmentName("front", 1, 1, 1).text()).write_bytes(b"x")
    disk = DiskRoom(tmp_path, 10**9, lambda _: FREE_BYTES_MIN - 100)
    assert len(disk.look()) == 1
    assert not disk.has_room
