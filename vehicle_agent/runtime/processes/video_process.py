"""The process that records a vehicle's cameras. Tick and gate know nothing of it."""

import os
import signal
from pathlib import Path
from types import FrameType

from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.video.camera_recorder import CameraCondition, CameraRecorder, RecorderPlace
from vehicle_agent.runtime.video.cameras_file import VideoSettings
from vehicle_agent.runtime.video.disk_room import DiskRoom
from vehicle_agent.runtime.video.library import pyav
from vehicle_agent.runtime.video.segment_file import recover

LOOK_NS = 1_000_000_000
DISK_EVERY_LOOKS = 5
# Under what the supervisor waits before it kills.
STOP_WITHIN_S = 4.0
# The tick comes first to a core. At 10, a computer with other work beside left out half of the pictures.
NICE = 5


class VideoProcess:
    """Begins to record when it is made; call `look` about once a second, and `close` at the end."""

    def __init__(self, settings: VideoSettings, folder: Path, clock: Clock) -> None:
        """folder: of the segments. Raises VideoLibraryMissing, OSError."""
        pyav()
        folder.mkdir(parents=True, exist_ok=True)
        recover(folder)
        self._disk = DiskRoom(folder, round(settings.keep_gib * 1024**3))
        self._disk.look()
        place = RecorderPlace(folder, lambda: self._disk.has_room, clock.now_ns, clock.utc_offset_ns)
        self.cameras = {
            camera.name: CameraRecorder(camera, settings.segment_s, place) for camera in settings.cameras
        }
        self._looks = 0
        for recorder in self.cameras.values():
            recorder.start()

    def look(self) -> tuple[CameraCondition, ...]:
        """How it stands with each camera. Keeps the disk from running full."""
        self._looks += 1
        if self._looks % DISK_EVERY_LOOKS == 0:
            self._disk.look()
        return tuple(recorder.condition for recorder in self.cameras.values())

    def close(self) -> None:
        for recorder in self.cameras.values():
            recorder.stop()
        for recorder in self.cameras.values():
            recorder.join(STOP_WITHIN_S / len(self.cameras))


def serve_video(settings: VideoSettings, folder: Path, clock: Clock) -> None:
    """Until SIGTERM. Raises VideoLibraryMissing, OSError."""
    stopping = False

    def stop(_number: int, _frame: FrameType | None) -> None:
        nonlocal stopping
        stopping = True

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(NICE)
    process = VideoProcess(settings, folder, clock)
    while not stopping:
        clock.wait(clock.now_ns() + LOOK_NS)
        process.look()
    process.close()
