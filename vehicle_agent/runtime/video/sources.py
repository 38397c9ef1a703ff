"""Pictures of one camera as they come: V4L2, RTSP and files through PyAV, and the ring of a driver."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from vehicle_agent.device_feed import DeviceFeedError
from vehicle_agent.picture_ring import PictureRing
from vehicle_agent.runtime.video.cameras_file import RecordedCamera
from vehicle_agent.runtime.video.library import pyav

# A stream that says nothing for so long is opened again.
OPEN_TIMEOUT_S, READ_TIMEOUT_S = 5.0, 3.0
# A ring of 32 pictures at 30 Hz lasts 1 s.
_POLL_S = 0.02

Now = Callable[[], int]


class SourceFailure(Exception):
    """The camera gives no picture; the message says why."""


class SourceFrame(NamedTuple):
    """frame    an `av.VideoFrame`, or None where nothing came in a while
    missed   pictures lost before this one
    damaged  pictures before this one that could not be decoded
    """

    stamp_ns: int
    frame: Any
    missed: int = 0
    damaged: int = 0


class Source(Protocol):
    def read(self) -> SourceFrame:
        """The next picture; waits for some time. Raises SourceFailure when the camera is gone."""
        ...

    def close(self) -> None: ...


def open_source(camera: RecordedCamera, now_ns: Now) -> Source:
    """Raises SourceFailure."""
    if camera.entry.source == "ring":
        return RingSource(Path(camera.address), now_ns)
    return StreamSource(camera, now_ns)


class RingSource:
    """A ring whose driver may be started later, and again."""

    def __init__(self, path: Path, now_ns: Now) -> None:
        try:
            self._ring = PictureRing(path, create=False)
        except DeviceFeedError as error:
            raise SourceFailure(str(error)) from error
        self._now_ns, self._frames = now_ns, pyav().VideoFrame
        self._silent_until_s = time.monotonic() + READ_TIMEOUT_S

    def read(self) -> SourceFrame:
        picture = self._ring.read()
        if picture is not None:
            self._silent_until_s = time.monotonic() + READ_TIMEOUT_S
            frame = self._frames.from_ndarray(picture.pixels, format="rgb24")
            return SourceFrame(picture.stamp_ns, frame, picture.missed)
        if time.monotonic() > self._silent_until_s:
            raise SourceFailure(f"no picture for {READ_TIMEOUT_S:.0f} s; its driver has ended or hangs")
        time.sleep(_POLL_S)
        return SourceFrame(self._now_ns(), None)

    def close(self) -> None:
        self._ring.close()


class StreamSource:
    """A device, a stream or a file, which is played at its own rate. Pictures have the time of arrival."""

    def __init__(self, camera: RecordedCamera, now_ns: Now) -> None:
        av = pyav()
        entry, self._now_ns, self._errors = camera.entry, now_ns, av.FFmpegError
        options: dict[str, str] = {}
        kind = None
        self._is_file = False
        if entry.source.startswith("/dev/video"):
            kind = "v4l2"
            options = {"video_size": f"{entry.width_px}x{entry.height_px}", "framerate": f"{entry.rate_hz:g}"}
        elif "://" in entry.source:
            # Over UDP every lost packet is a torn picture.
            options = {"rtsp_transport": "tcp"}
        else:
            self._is_file = True
        try:
            self._container = av.open(
                camera.address, format=kind, options=options, timeout=(OPEN_TIMEOUT_S, READ_TIMEOUT_S)
            )
        except (av.FFmpegError, OSError, ValueError) as error:
            raise SourceFailure(f"{entry.source} cannot be opened: {_reason(error)}") from error
        if not self._container.streams.video:
            self._container.close()
            raise SourceFailure(f"{entry.source} has no video in it")
        self._stream = self._container.streams.video[0]
        self._stream.codec_context.thread_count = 1
        self._packets: Iterator[Any] = self._container.demux(self._stream)
        self._waiting: list[Any] = []
        self._began_ns: int | None = None
        self._source = entry.source
        self._has_ended = False

    def read(self) -> SourceFrame:
        damaged = 0
        while not self._waiting:
            if self._has_ended:
                raise SourceFailure(f"{self._source} has ended" if self._is_file else f"{self._source} ended")
            try:
                packet = next(self._packets)
                self._has_ended = packet.dts is None
            except StopIteration:
                self._has_ended = True
                continue
            except (self._errors, OSError) as error:
                raise SourceFailure(f"{self._source} gives no more pictures: {_reason(error)}") from error
            damaged += bool(getattr(packet, "is_corrupt", False))
            try:
                self._waiting = list(packet.decode())
            except self._errors:
                damaged += 1
            if damaged > 100:
                raise SourceFailure(f"{self._source}: a hundred pictures in a row cannot be decoded")
        frame = self._waiting.pop(0)
        if self._is_file:
            self._keep_pace(float(frame.time or 0.0))
        return SourceFrame(self._now_ns(), frame, 0, damaged)

    def _keep_pace(self, at_s: float) -> None:
        now_ns, at_ns = self._now_ns(), round(at_s * 1e9)
        if self._began_ns is None:
            self._began_ns = now_ns - at_ns
        time.sleep(min(max(0.0, (self._began_ns + at_ns - now_ns) / 1e9), 1.0))

    def close(self) -> None:
        self._container.close()


def _reason(error: Exception) -> str:
    """Without the address, which may have a password in it."""
    return str(getattr(error, "strerror", "") or type(error).__name__)


def luma_of(frame: Any) -> np.ndarray:
    """(h, w) uint8 of a frame in yuv420p, without a copy."""
    plane = frame.planes[0]
    rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)
    luma: np.ndarray = rows[: plane.height, : plane.width]
    return luma
