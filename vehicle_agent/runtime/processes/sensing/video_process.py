"""The process that records a vehicle's cameras. Tick and gate know nothing of it."""

import os
import signal
from pathlib import Path
from types import FrameType

import structlog

from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.mailbox import Mailbox
from vehicle_agent.runtime.video.camera_recorder import CameraCondition, CameraRecorder, RecorderPlace
from vehicle_agent.runtime.video.camera_view import CameraShown, CameraView, ShowCamera
from vehicle_agent.runtime.video.cameras_file import VideoSettings
from vehicle_agent.runtime.video.disk_room import DiskRoom
from vehicle_agent.runtime.video.library import pyav
from vehicle_agent.runtime.video.outgoing import Outgoing
from vehicle_agent.runtime.video.segment_file import recover
from vehicle_agent.runtime.video.wanted_spans import VideoMark

log = structlog.get_logger()

LOOK_NS = 1_000_000_000
SHOW_NS = 250_000_000
DISK_EVERY_LOOKS = 5
# Under what the supervisor waits before it kills.
STOP_WITHIN_S = 4.0
# The tick comes first to a core: without, a busy computer's ticks took four times as long (decision 39).
NICE = 10


class VideoProcess:
    """Begins to record when it is made. Call `look` once a second, `show` more often, `close` at the end."""

    def __init__(self, settings: VideoSettings, folder: Path, clock: Clock, mail: Path | None = None) -> None:
        """folder: of the segments; mail: of the vehicle's mailboxes, None for nothing that leaves.

        Raises VideoLibraryMissing, OSError.
        """
        pyav()
        folder.mkdir(parents=True, exist_ok=True)
        recover(folder)
        self._outgoing = Outgoing(folder, settings.upload, settings.blur)
        self._mailbox = None if mail is None else Mailbox(mail / "video")
        self._link = None if mail is None else mail / "link"
        self._clock = clock
        self._disk = DiskRoom(folder, round(settings.keep_gib * 1024**3))
        self._disk.look()
        is_coarse = settings.blur == "whole"
        place = RecorderPlace(
            folder, lambda: self._disk.has_room, clock.now_ns, clock.utc_offset_ns, is_coarse=is_coarse
        )
        self.cameras = {
            camera.name: CameraRecorder(camera, settings.segment_s, place) for camera in settings.cameras
        }
        self._view = CameraView(self.cameras, is_private=settings.upload == "never", is_coarse=is_coarse)
        self._looks = 0
        for recorder in self.cameras.values():
            recorder.start()

    def look(self) -> tuple[CameraCondition, ...]:
        """How it stands with each camera. Keeps the disk from running full."""
        self._looks += 1
        self._take_mail()
        try:
            self._outgoing.prepare()
        except OSError as error:
            log.error("video.not_prepared", error=str(error))
        if self._looks % DISK_EVERY_LOOKS == 0:
            self._disk.look()
        return tuple(recorder.condition for recorder in self.cameras.values())

    def show(self) -> None:
        """Send new pictures to operators who look."""
        self._take_mail()
        if self._mailbox is None or self._link is None:
            return
        for picture in self._view.news(self._clock.now_ns()):
            self._mailbox.post(self._link, CameraShown(picture))

    def close(self) -> None:
        for recorder in self.cameras.values():
            recorder.stop()
        for recorder in self.cameras.values():
            recorder.join(STOP_WITHIN_S / len(self.cameras))
        if self._mailbox is not None:
            self._mailbox.close()

    def _take_mail(self) -> None:
        for mail in () if self._mailbox is None else self._mailbox.take():
            if isinstance(mail, ShowCamera):
                self._view.ask(mail)
            elif isinstance(mail, VideoMark):
                self._take_mark(mail)

    def _take_mark(self, mark: VideoMark) -> None:
        try:
            self._outgoing.note(mark)
        except OSError as error:
            log.error("video.not_noted", mark_id=mark.mark_id, error=str(error))
        if mark.kind == "stop_recording":
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
    looked_ns = clock.now_ns()
    while not stopping:
        clock.wait(clock.now_ns() + SHOW_NS)
        process.show()
        if clock.now_ns() - looked_ns >= LOOK_NS:
            looked_ns = clock.now_ns()
            process.look()
    process.close()
