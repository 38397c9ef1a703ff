"""A camera becomes files that play: at its times, with its faults told, and whole after any fault."""

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contract.video import SegmentName
from vehicle_agent.runtime.video.camera_recorder import CameraRecorder, RecorderPlace
from vehicle_agent.runtime.video.cameras_file import CameraEntry, RecordedCamera
from vehicle_agent.runtime.video.segment_file import SegmentFile, recover
from vehicle_agent.runtime.video.segment_names import segments_in
from vehicle_agent.runtime.video.sources import Source, SourceFailure, SourceFrame, open_source

av = pytest.importorskip("av", reason="PyAV is not installed (make video)")
OFFSET_NS = 1_700_000_000_000_000_000
SIZE = (160, 120)
CAMERA = RecordedCamera("front", CameraEntry("ring", *SIZE), "")


def frame(number: int, level: int = 120) -> Any:
    """Its brightness tells its number."""
    pixels = np.random.default_rng(number).integers(0, 8, (SIZE[1], SIZE[0], 3), dtype=np.uint8)
    return av.VideoFrame.from_ndarray(pixels + np.uint8(level), format="rgb24")


class Scripted:
    """A camera that gives these frames and then fails."""

    def __init__(self, frames: list[SourceFrame], then: Exception) -> None:
        self._frames, self._then = iter(frames), then

    def read(self) -> SourceFrame:
        try:
            return next(self._frames)
        except StopIteration:
            raise self._then from None

    def close(self) -> None: ...


def recorded(
    folder: Path, sources: Iterator[Source], until: Callable[[CameraRecorder], bool], **place: Any
) -> CameraRecorder:
    def open_next(_camera: RecordedCamera, _now: Callable[[], int]) -> Source:
        try:
            return next(sources)
        except StopIteration:
            raise SourceFailure("unplugged") from None

    at = RecorderPlace(folder, place.get("has_room", lambda: True), lambda: 0, lambda: OFFSET_NS, open_next)
    recorder = CameraRecorder(CAMERA, 5.0, at)
    recorder.start()
    for _ in range(1000):
        if until(recorder):
            break
        time.sleep(0.01)
    recorder.stop()
    assert recorder.join(10.0)
    return recorder


def at(stamps_s: list[float]) -> list[SourceFrame]:
    return [SourceFrame(round(stamp * 1e9), frame(number)) for number, stamp in enumerate(stamps_s)]


def times_s(path: Path) -> list[float]:
    with av.open(str(path)) as container:
        return [round(one.time, 3) for one in container.decode(video=0)]


def test_every_picture_is_in_the_file_of_its_time(tmp_path: Path) -> None:
    stamps_s = [98.0 + 0.1 * number for number in range(100)]
    source = Scripted(at(stamps_s), SourceFailure("unplugged"))
    recorder = recorded(
        tmp_path,
        iter([source]),
        lambda one: one.condition.state == "no_picture" and one.condition.recorded > 0,
    )
    names = segments_in(tmp_path)
    assert [name.stamp_ns // 10**9 for name in names] == [98, 100, 105]
    assert all(name.utc_ns - name.stamp_ns == OFFSET_NS for name in names)
    found = [
        round(name.stamp_ns / 1e9 + at_s, 2) for name in names for at_s in times_s(tmp_path / name.text())
    ]
    assert found == [round(stamp, 2) for stamp in stamps_s]
    assert (recorder.condition.recorded, recorder.condition.missed) == (100, 0)


def test_files_can_be_sought_to_every_second(tmp_path: Path) -> None:
    file = SegmentFile(tmp_path, SegmentName("front", 0, OFFSET_NS), SIZE, 10.0, 400)
    for number in range(50):
        file.add(number * 100_000_000, frame(number).reformat(format="yuv420p"))
    path = file.close()
    with av.open(str(path)) as container:
        keys = [
            float(p.pts * p.time_base)
            for p in container.demux(video=0)
            if p.dts is not None and p.is_keyframe
        ]
        assert keys == [0.0, 1.0, 2.0, 3.0, 4.0]
        container.seek(3_500_000)
        assert next(container.decode(video=0)).time == pytest.approx(3.0)


def test_an_unplugged_camera_comes_back_in_a_segment_of_its_own(tmp_path: Path) -> None:
    first = Scripted(at([1.0, 1.1, 1.2]), SourceFailure("no such device"))
    second = Scripted(at([4.0, 4.1]), SourceFailure("no such device"))
    recorder = recorded(tmp_path, iter([first, second]), lambda one: one.condition.recorded == 5)
    assert [name.length_ms for name in segments_in(tmp_path)] == [200, 100]
    assert recorder.condition.recorded == 5


def test_a_source_that_breaks_in_an_unknown_way_stops_nothing(tmp_path: Path) -> None:
    first = Scripted(at([1.0, 1.1]), RuntimeError("torn"))
    second = Scripted(at([9.0, 9.1, 9.2]), SourceFailure("end"))
    recorder = recorded(tmp_path, iter([first, second]), lambda one: one.condition.recorded == 5)
    recover(tmp_path)
    assert [name.length_ms for name in segments_in(tmp_path)][-1] == 200
    assert recorder.condition.recorded == 5


def test_black_and_frozen_pictures_are_recorded_and_told(tmp_path: Path) -> None:
    still = frame(1)
    source = Scripted([SourceFrame(n * 100_000_000, still) for n in range(30)], SourceFailure("end"))
    seen: set[str] = set()

    def look(one: CameraRecorder) -> bool:
        seen.add(one.condition.state)
        return one.condition.recorded == 30

    class Slow(Scripted):
        def read(self) -> SourceFrame:
            time.sleep(0.005)
            return super().read()

    source = Slow([SourceFrame(n * 100_000_000, still) for n in range(30)], SourceFailure("end"))
    recorded(tmp_path, iter([source]), look)
    assert "frozen" in seen


def test_a_full_disk_costs_video_only(tmp_path: Path) -> None:
    room = threading.Event()
    source = Scripted(at([0.1 * n for n in range(10)]), SourceFailure("end"))
    recorder = recorded(
        tmp_path, iter([source]), lambda one: one.condition.missed == 10, has_room=room.is_set
    )
    assert (recorder.condition.recorded, recorder.condition.missed) == (0, 10)
    assert segments_in(tmp_path) == []


def test_what_a_kill_left_is_finished_and_plays_to_its_end(tmp_path: Path) -> None:
    file = SegmentFile(tmp_path, SegmentName("front", 0, OFFSET_NS), SIZE, 10.0, 400)
    for number in range(38):
        file.add(number * 100_000_000, frame(number).reformat(format="yuv420p"))
    file.abandon()
    (tmp_path / SegmentName("rear", 0, OFFSET_NS).text()).write_bytes(b"")
    (tmp_path / SegmentName("left", 0, OFFSET_NS).text()).write_bytes(b"no video at all" * 50)
    (path,) = recover(tmp_path)
    (name,) = segments_in(tmp_path)
    assert name.camera == "front"
    assert name.length_ms is not None
    assert 3700 - name.length_ms <= 1100
    assert times_s(path)[-1] * 1000 == name.length_ms
    assert recover(tmp_path) == []


def test_a_video_file_is_played_at_its_own_rate(tmp_path: Path) -> None:
    file = SegmentFile(tmp_path, SegmentName("front", 0, OFFSET_NS), SIZE, 10.0, 400)
    for number in range(5):
        file.add(number * 100_000_000, frame(number).reformat(format="yuv420p"))
    path = file.close()
    source = open_source(RecordedCamera("x", CameraEntry(str(path), *SIZE), str(path)), time.monotonic_ns)
    stamps = [source.read().stamp_ns for _ in range(5)]
    assert 0.35e9 <= stamps[-1] - stamps[0] <= 2e9
    with pytest.raises(SourceFailure, match="has ended"):
        source.read()


@pytest.mark.parametrize("content", [b"", b"no video" * 100])
def test_a_file_that_is_no_video_is_told(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.avi"
    path.write_bytes(content)
    with pytest.raises(SourceFailure, match="cannot be opened"):
        open_source(RecordedCamera("x", CameraEntry(str(path)), str(path)), time.monotonic_ns)


def test_a_segment_that_cannot_be_closed_ends_no_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    close, failures = SegmentFile.close, iter([ValueError("the library refuses its own data")])

    def close_badly_once(file: SegmentFile) -> Path:
        for failure in failures:
            file.abandon()
            raise failure
        return close(file)

    monkeypatch.setattr(SegmentFile, "close", close_badly_once)
    sources = [Scripted(at([begin, begin + 0.1]), SourceFailure("unplugged")) for begin in (1.0, 20.0)]
    recorder = recorded(tmp_path, iter(sources), lambda one: one.condition.recorded == 4)
    assert recorder.condition.recorded == 4
    assert [name.stamp_ns // 10**9 for name in segments_in(tmp_path) if name.length_ms is not None] == [20]
