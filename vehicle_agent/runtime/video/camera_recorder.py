"""One camera in a thread of its own: opened again when it is gone, checked, encoded, cut into segments.

A camera that hangs, lies or is unplugged costs its own video only.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import msgspec
import structlog

from contract.video import SegmentName
from vehicle_agent.runtime.video.cameras_file import RecordedCamera
from vehicle_agent.runtime.video.library import pyav
from vehicle_agent.runtime.video.picture_checks import PictureState, check
from vehicle_agent.runtime.video.picture_taker import PictureTaker
from vehicle_agent.runtime.video.segment_file import SegmentFile
from vehicle_agent.runtime.video.segmenter import SegmentRules, SegmentState, Verdict, step
from vehicle_agent.runtime.video.sources import Source, SourceFailure, luma_of, open_source

log = structlog.get_logger()

CameraState = Literal["recording", "black", "frozen", "no_picture", "disk_full", "failed"]

GAP_NS = 2_000_000_000
# Between attempts to open a camera.
RETRY_S = (0.5, 1.0, 2.0, 5.0)


class CameraCondition(msgspec.Struct, frozen=True):
    """How it stands with one camera.

    state     recording, black, frozen (recorded all the same), no_picture, disk_full, failed
    recorded  pictures. missed: lost on their way to the encoder. damaged: that could not be decoded
    last_ns   of the newest picture, None before the first
    """

    camera: str
    state: CameraState = "no_picture"
    detail: str = ""
    recorded: int = 0
    missed: int = 0
    damaged: int = 0
    last_ns: int | None = None


@dataclass(slots=True)
class RecorderPlace:
    """folder: of all segments. has_room: whether the disk has room. The others are clocks and sources.

    is_coarse  what leaves the vehicle shows no face and no plate
    """

    folder: Path
    has_room: Callable[[], bool]
    now_ns: Callable[[], int]
    utc_offset_ns: Callable[[], int]
    open: Callable[[RecordedCamera, Callable[[], int]], Source] = field(default=open_source)
    is_coarse: bool = True


class CameraRecorder:
    """Call `start`, and at the end `stop`, then `join`. `condition` may be read at any time.

    taker  makes pictures for operators who look now
    """

    def __init__(self, camera: RecordedCamera, segment_s: float, place: RecorderPlace) -> None:
        entry = camera.entry
        self._camera, self._place = camera, place
        self._rules = SegmentRules(round(segment_s * 1e9), GAP_NS, round(1e9 / entry.rate_hz))
        self._cut, self._checked = SegmentState(), PictureState()
        self._file: SegmentFile | None = None
        # Kept: a new one for each picture takes as long as its work.
        self._reformatter = pyav().video.reformatter.VideoReformatter()
        self._stop, self._cut_now = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"camera {camera.name}", daemon=True)
        self.condition = CameraCondition(camera.name)
        self.taker = PictureTaker(place.is_coarse)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stop.set()

    def join(self, timeout_s: float) -> bool:
        """True: it has ended, and its segment is closed. A source that hangs leaves it to the next start."""
        self._thread.join(timeout_s)
        return not self._thread.is_alive()

    def begin_segment(self) -> None:
        """The next picture begins one: an operator wants the one before now."""
        self._cut_now.set()

    def _run(self) -> None:
        failures = 0
        while not self._stop.is_set():
            recorded = self.condition.recorded
            try:
                source = self._place.open(self._camera, self._place.now_ns)
                try:
                    self._follow(source)
                finally:
                    source.close()
            except SourceFailure as error:
                self._tell("no_picture", str(error))
            except Exception as error:  # noqa: BLE001 - a camera's fault of any kind is that camera's alone
                self._tell("failed", f"{type(error).__name__}: {error}")
                self._give_up()
            self._close()
            failures = 0 if self.condition.recorded > recorded else failures + 1
            if self._stop.wait(RETRY_S[min(failures, len(RETRY_S) - 1)] if failures else 0.05):
                break

    def _follow(self, source: Source) -> None:
        entry = self._camera.entry
        while not self._stop.is_set():
            stamp_ns, frame, missed, damaged = source.read()
            if missed or damaged:
                self._count(missed=missed, damaged=damaged)
            if frame is None:
                continue
            verdict, cut = step(self._cut, stamp_ns, self._rules)
            if verdict in (Verdict.SURPLUS, Verdict.LATE):
                continue
            self._cut = cut
            planar = self._reformatter.reformat(frame, entry.width_px, entry.height_px, "yuv420p")
            if entry.turned:
                planar = _turned(planar)
            self._checked = check(self._checked, stamp_ns, luma_of(planar))
            self.taker.offer(stamp_ns, planar)
            self._write(verdict is Verdict.BEGIN, stamp_ns, planar)

    def _write(self, begins: bool, stamp_ns: int, frame: Any) -> None:
        entry, trouble = self._camera.entry, self._checked.trouble
        if begins or self._cut_now.is_set():
            self._cut_now.clear()
            self._close()
        try:
            if self._file is None:
                if not self._place.has_room():
                    self._count(missed=1)
                    self._tell("disk_full", "there is no room for video", stamp_ns)
                    return
                name = SegmentName(self._camera.name, stamp_ns, stamp_ns + self._place.utc_offset_ns())
                size_px = (entry.width_px, entry.height_px)
                self._file = SegmentFile(self._place.folder, name, size_px, entry.rate_hz, entry.kbps)
            self._file.add(stamp_ns, frame)
        except OSError as error:
            self._count(missed=1)
            self._tell("disk_full", str(error.strerror or error), stamp_ns)
            self._give_up()
            return
        self._count(recorded=1)
        self._tell(trouble or "recording", "", stamp_ns)

    def _close(self) -> None:
        file, self._file = self._file, None
        if file is None:
            return
        try:
            path = file.close()
            log.info("video.segment", camera=self._camera.name, file=path.name, pictures=file.pictures)
        except Exception as error:  # noqa: BLE001 - the thread goes on: the next start recovers this segment
            log.error("video.segment_not_closed", camera=self._camera.name, error=str(error))

    def _give_up(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            file.abandon()

    def _count(self, recorded: int = 0, missed: int = 0, damaged: int = 0) -> None:
        one = self.condition
        self.condition = msgspec.structs.replace(
            one, recorded=one.recorded + recorded, missed=one.missed + missed, damaged=one.damaged + damaged
        )

    def _tell(self, state: CameraState, detail: str, stamp_ns: int | None = None) -> None:
        before = self.condition
        last_ns = before.last_ns if stamp_ns is None else stamp_ns
        self.condition = msgspec.structs.replace(before, state=state, detail=detail, last_ns=last_ns)
        if (before.state, before.detail) != (state, detail):
            level = log.info if state == "recording" else log.warning
            level("video.camera", camera=self._camera.name, state=state, detail=detail)


def _turned(frame: Any) -> Any:
    """The picture turned by half a turn."""
    pixels = frame.to_ndarray()
    rows, width = frame.height, frame.width
    turned = pixels.copy()
    turned[:rows] = pixels[:rows][::-1, ::-1]
    chroma = rows * width // 4
    flat, out = pixels[rows:].reshape(-1), turned[rows:].reshape(-1)
    for start in (0, chroma):
        out[start : start + chroma] = flat[start : start + chroma][::-1]
    return type(frame).from_ndarray(turned, format="yuv420p")
