"""The process that records a vehicle's cameras. Tick and gate know nothing of it."""

import os
import signal
from pathlib import Path
from types import FrameType

import structlog

from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.mailbox import Mailbox
from vehicle_agent.runtime.video.camera_recorder import CameraCondition, CameraRecorder, RecorderPlace
from vehicle_agent.runtime.video.cameras_file import VideoSettings
from vehicle_agent.runtime.video.disk_room import DiskRoom
from vehicle_agent.runtime.video.library import pyav
from vehicle_agent.runtime.video.outgoing import Outgoing
from vehicle_agent.runtime.video.segment_file import recover
from vehicle_agent.runtime.video.wanted_spans import VideoMark

log = structlog.get_logger()

LOOK_NS = 1_000_000_000
DISK_EVERY_LOOKS = 5
# Under what the supervisor waits before it kills.
STOP_WITHIN_S = 4.0
# The tick comes first to a core: without, a busy computer's ticks took four times as long (decision 39).
NICE = 10


class VideoProcess:
    """Begins to record when it is made; call `look` about once a second, and `close` at the end."""

    def __init__(self, settings: VideoSettings, folder: Path, clock: Clock, mail: Path | None = None) -> None:
        """folder: of the segments; mail: of the vehicle's mailboxes, None for nothing that leaves.

        Raises VideoLibraryMissing, OSError.
        """
        pyav()
        folder.mkdir(parents=True, exist_ok=True)
        recover(folder)
        self._outgoing = Outgoing(folder, settings.upload, settings.blur)
        self._mailbox = None if mail is None else Mailbox(mail / "video")
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
        try:
            self._take_marks()
            self._outgoing.prepare()
        except OSError as error:
            log.error("video.not_prepared", error=str(error))
        if self._looks % DISK_EVERY_LOOKS == 0:
            self._disk.look()
        return tuple(recorder.condition for recorder in self.cameras.values())

    def close(self) -> None:
        for recorder in self.cameras.values():
            recorder.stop()
        for recorder in self.cameras.values():
            recorder.join(STOP_WITHIN_S / len(self.cameras))
        if self._mailbox is not None:
            self._mailbox.close()

    def _take_marks(self) -> None:
        """Raises OSError."""
        for mail in () if self._mailbox is None else self._mailbox.take():
            if isinstance(mail, VideoMark):
                self._outgoing.note(mail)
                if mail.kind == "stop_recording":
                    # Its last pictures are wanted now, as the run log's are.
                    for recorder in self.cameras.values():
                        recorder.begin_segment()


def serve_video(settings: VideoSettings, folder: Path, clock: Clock, mail: Path | None = None) -> None:
    """Until SIGTERM. Raises VideoLibraryMissing, OSError."""
    stopping = False

    def stop(_number: int, _frame: FrameType | None) -> None:
        nonlocal stopping
        stopping = True

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(NICE)
    process = VideoProcess(settings, folder, clock, mail)
    while not stopping:
        clock.wait(clock.now_ns() + LOOK_NS)
        process.look()
    process.close()
