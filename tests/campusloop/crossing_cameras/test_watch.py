"""A crossing's camera: its counts, and what is said when its video is absent, ends or shows nothing."""

import asyncio
from pathlib import Path

import numpy as np
import pytest

from campusloop.crossing_cameras import watch
from campusloop.crossing_cameras.ground_pixels import GroundPixels
from campusloop.crossing_cameras.video import Video, VideoFailure
from campusloop.crossing_cameras.watch import CrossingWatch, WatchOptions
from contract.wire.messages import PresenceReport
from simulator.infrastructure import CameraParams, CrossingCamera
from tests.simulator.sensors.scene.campus import a_street
from tests.vehicle_agent.perception.camera.test_people_detector import a_dummy

cv2 = pytest.importorskip("cv2", reason="the extra `camera` is not installed")

from campusloop.crossing_cameras.people_counter import PeopleCounter  # noqa: E402 - needs OpenCV

# 48 px a metre along the rows: a person is about 76 px high, and a row further up is further away.
GROUND = GroundPixels(
    [(0, 120), (320, 120), (0, 235), (320, 235)], [(-3.3, 9), (3.3, 9), (-3.3, 7), (3.3, 7)]
)
AREA = np.array([[-2.5, 6.8], [2.5, 6.8], [2.5, 9.0], [-2.5, 9.0]])


def a_picture(number: int, with_person: bool) -> np.ndarray:
    """The dummy has its feet at (160, 200); the ground is darker further down."""
    pixels = a_dummy(76) if with_person else np.full((240, 320, 3), 190, np.uint8)
    noise = np.random.default_rng(number).normal(0.0, 3.0, pixels.shape)
    darker = np.linspace(0.0, 40.0, 240)[:, None, None]
    return np.clip(pixels + noise - darker, 0, 255).astype(np.uint8)


def a_video(path: Path, pictures: list[np.ndarray]) -> str:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10.0, (320, 240))
    for pixels in pictures:
        writer.write(pixels)
    writer.release()
    return str(path)


def test_a_person_who_comes_is_counted_and_one_who_goes_is_not() -> None:
    counter = PeopleCounter(GROUND, AREA)
    empty = [counter.count(a_picture(k, False)) for k in range(8)]
    there = [counter.count(a_picture(k, True)) for k in range(8, 13)]
    gone = [counter.count(a_picture(k, False)) for k in range(13, 20)]
    assert empty == [0] * 8
    assert there[2:] == [1] * 3
    assert gone[-2:] == [0] * 2


def test_a_person_who_stands_there_from_the_first_picture_is_counted() -> None:
    counter = PeopleCounter(GROUND, AREA)
    assert [counter.count(a_picture(k, True)) for k in range(9)][-4:] == [1] * 4


class Watched:
    """Runs a watch and keeps what it reports and tells."""

    def __init__(self, source: str, once: bool = True) -> None:
        self.reports: list[PresenceReport] = []
        self.told: list[str] = []
        self.watch = CrossingWatch(
            source, lambda: PeopleCounter(GROUND, AREA), WatchOptions("crossing", 10.0, once),
            self.reports.append, self.told.append,
        )  # fmt: skip

    def run(self) -> VideoFailure:
        with pytest.raises(VideoFailure) as caught:
            asyncio.run(self.watch.run())
        return caught.value


def test_a_video_is_reported_to_its_end(tmp_path: Path) -> None:
    pictures = [a_picture(k, 6 <= k < 14) for k in range(16)]
    watched = Watched(a_video(tmp_path / "crossing.avi", pictures))
    assert watched.run().has_ended
    counts = [report.count for report in watched.reports]
    assert max(counts) == 1
    assert counts[0] == 0
    assert {report.area_id for report in watched.reports} == {"crossing"}


def test_pictures_that_show_nothing_are_told_and_not_reported(tmp_path: Path) -> None:
    black = np.zeros((240, 320, 3), np.uint8)
    watched = Watched(a_video(tmp_path / "black.avi", [black] * 5))
    watched.run()
    assert watched.reports == []
    assert any("black" in text and "no reports" in text for text in watched.told)


def test_absent_and_broken_videos_are_named(tmp_path: Path) -> None:
    assert "there is no video file" in str(Watched(str(tmp_path / "absent.avi")).run())
    (tmp_path / "broken.avi").write_bytes(b"no video" * 100)
    assert "no video that OpenCV can read" in str(Watched(str(tmp_path / "broken.avi")).run())
    with pytest.raises(VideoFailure, match="cannot be opened"):
        Video("/dev/video987")


def test_a_video_that_comes_back_is_reported_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "_REOPEN_S", (0.05,))
    path = tmp_path / "late.avi"
    watched = Watched(str(path), once=False)

    async def drive() -> None:
        task = asyncio.create_task(watched.watch.run())
        await asyncio.sleep(0.2)
        assert watched.reports == []
        a_video(path, [a_picture(k, False) for k in range(4)])
        # The video is played, ends, and is opened again.
        while sum("has ended" in text for text in watched.told) < 2:
            assert not task.done()
            await asyncio.sleep(0.05)
        task.cancel()

    asyncio.run(asyncio.wait_for(drive(), 60.0))
    assert any("there is no video file" in text for text in watched.told)
    assert len(watched.reports) >= 4


def test_a_simulated_camera_reports_what_its_detector_counts_and_nothing_of_a_bad_picture() -> None:
    answers = {0: 2, 1: None, 2: 0}
    camera = CrossingCamera(
        a_street().observation_areas[0],
        CameraParams(rate_hz=1.0, miss=1.0, ghost=1.0, dropout=0.0, latency_s=0.2),
        np.random.default_rng(1), lambda taken_ns: answers.get(taken_ns // 10**9),
    )  # fmt: skip
    said = [report for now in range(0, 160) for report in camera.step(now * 20_000_000, np.zeros((5, 2)))]
    assert [report.count for report in said] == [2, 0]
    assert all(0.2 <= report.age_s < 0.23 for report in said)
