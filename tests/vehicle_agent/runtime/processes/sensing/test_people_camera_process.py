"""The camera for people: its pictures, freed of the lens, lie in the ring; what it cannot give is told."""

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from structlog.testing import capture_logs

from vehicle_agent.config import Camera
from vehicle_agent.perception.camera.lens import Lens
from vehicle_agent.picture_ring import PictureRing, RingPicture
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.sensing import people_camera_process
from vehicle_agent.runtime.processes.sensing.people_camera_process import PeopleCameraProcess
from vehicle_agent.runtime.video.cameras_file import RecordedCamera
from vehicle_agent.runtime.video.people_camera import PeopleCamera, PeopleCameraEntry
from vehicle_agent.runtime.video.sources import Source, SourceFailure, SourceFrame

PARAMS = Camera(rate_hz=10.0, width_px=320, height_px=240)
PICTURE_NS = 33_333_333
NOW_NS = 5_000_000_000


class Frame:
    """As PyAV's frames are asked for their pixels."""

    def __init__(self, pixels: np.ndarray) -> None:
        self._pixels = pixels

    def to_ndarray(self, format: str) -> np.ndarray:
        assert format == "rgb24"
        return self._pixels


class Played:
    """A camera that gives these pictures, 30 a second, and then is gone."""

    def __init__(self, pictures: list[np.ndarray]) -> None:
        self._frames = [
            SourceFrame(NOW_NS + number * PICTURE_NS, Frame(picture))
            for number, picture in enumerate(pictures)
        ]

    def read(self) -> SourceFrame:
        if not self._frames:
            raise SourceFailure("it was unplugged")
        return self._frames.pop(0)

    def close(self) -> None:
        pass


def taken(
    folder: Path, sources: list[Source | SourceFailure], entry: PeopleCameraEntry, lens: Lens | None = None
) -> list[RingPicture]:
    """The pictures in the ring when all of these have been opened and have ended."""
    left = list(sources)
    ended = threading.Event()

    def opened(_camera: RecordedCamera, _now: Callable[[], int]) -> Source:
        if not left:
            ended.set()
            raise SourceFailure("it is away")
        source = left.pop(0)
        if isinstance(source, SourceFailure):
            raise source
        return source

    camera = PeopleCamera(entry, "/dev/video0", lens)
    process = PeopleCameraProcess(camera, PARAMS, folder / "ring", MONOTONIC, opened)
    ring = PictureRing(folder / "ring", create=False)
    thread = threading.Thread(target=process.run)
    thread.start()
    assert ended.wait(10.0)
    process.stop()
    thread.join(10.0)
    assert not thread.is_alive()
    found = []
    while (picture := ring.read()) is not None:
        found.append(picture)
    return found


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(people_camera_process, "RETRY_S", 0.01)


def pictures(count: int, height: int = 240, width: int = 320) -> list[np.ndarray]:
    rng = np.random.default_rng(count)
    return [rng.integers(0, 255, (height, width, 3), dtype=np.uint8) for _ in range(count)]


def test_a_picture_lies_in_the_ring_as_often_as_the_profile_looks_at_its_own_moment(tmp_path: Path) -> None:
    shown = pictures(30)
    found = taken(tmp_path, [Played(shown)], PeopleCameraEntry("/dev/video0", latency_ms=40.0))
    assert len(found) == 10
    assert [one.stamp_ns for one in found[:2]] == [NOW_NS - 40_000_000, NOW_NS - 40_000_000 + 3 * PICTURE_NS]
    assert np.array_equal(found[1].pixels, shown[3])


def test_a_camera_that_hangs_upside_down_is_turned(tmp_path: Path) -> None:
    shown = pictures(1)
    (found,) = taken(tmp_path, [Played(shown)], PeopleCameraEntry("/dev/video0", turned=True))
    assert np.array_equal(found.pixels, shown[0][::-1, ::-1])


def test_a_lens_is_taken_out_and_the_picture_has_the_profiles_size(tmp_path: Path) -> None:
    pytest.importorskip("cv2", reason="needs the extra `camera`")
    lens = Lens(640, 480, 500.0, 500.0, 320.0, 240.0, (-0.2, 0.05, 0.0, 0.0))
    (found,) = taken(tmp_path, [Played(pictures(1, 480, 640))], PeopleCameraEntry("/dev/video0"), lens)
    assert found.pixels.shape == (240, 320, 3)


def test_a_lens_that_sees_too_little_of_the_profiles_picture_is_told(tmp_path: Path) -> None:
    pytest.importorskip("cv2", reason="needs the extra `camera`")
    narrow = Lens(640, 480, 1_200.0, 1_200.0, 320.0, 240.0, (0.0, 0.0, 0.0, 0.0))
    with capture_logs() as logs:
        taken(tmp_path, [Played(pictures(1, 480, 640))], PeopleCameraEntry("/dev/video0"), narrow)
    assert logs[0]["event"] == "camera.narrow_lens"


def test_pictures_of_another_size_are_refused_and_the_camera_is_asked_again(tmp_path: Path) -> None:
    with capture_logs() as logs:
        found = taken(
            tmp_path,
            [
                SourceFailure("/dev/video0 cannot be opened: No such file"),
                SourceFailure("/dev/video0 cannot be opened: No such file"),
                Played(pictures(2, 480, 640)),
                Played(pictures(1)),
            ],
            PeopleCameraEntry("/dev/video0"),
        )
    assert len(found) == 1, "the one that has the right size"
    told = [line["error"] for line in logs if line["event"] == "sensor.not_open"]
    assert told[0] == "/dev/video0 cannot be opened: No such file"
    assert told[1].startswith("pictures have 640 x 480 px, and the profile's [camera] 320 x 240")
    assert told[2:] == ["it was unplugged", "it is away"], "each reason once"
    assert [line["event"] for line in logs].count("sensor.open") == 1


@pytest.mark.real
def test_a_video_file_is_a_camera(tmp_path: Path) -> None:
    av = pytest.importorskip("av", reason="needs the extra `video`")
    path = tmp_path / "drive.mkv"
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream("libvpx", rate=30)
        stream.width, stream.height, stream.pix_fmt = 320, 240, "yuv420p"
        for picture in pictures(30):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    camera = PeopleCamera(PeopleCameraEntry("drive.mkv"), str(path), None)
    process = PeopleCameraProcess(camera, PARAMS, tmp_path / "ring", MONOTONIC)
    thread = threading.Thread(target=process.run)
    thread.start()
    ring, found, until_s = PictureRing(tmp_path / "ring", create=False), 0, time.monotonic() + 20.0
    while found < 5 and time.monotonic() < until_s:
        found += ring.read() is not None
        time.sleep(0.01)
    process.stop()
    thread.join(10.0)
    assert found == 5
