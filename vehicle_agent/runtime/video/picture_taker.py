"""Small JPEGs of a camera's pictures, made in the camera's thread while an operator looks."""

from fractions import Fraction
from typing import Any, NamedTuple

import structlog

from contract.wire.camera_picture import PICTURE_BYTES_MAX
from vehicle_agent.runtime.video.coarse import BLOCK_PX
from vehicle_agent.runtime.video.library import pyav

log = structlog.get_logger()

WIDTH_PX_MAX = 480
# Of pictures at 10 Hz every fifth: twice a second.
EVERY_NS = 450_000_000
# libavcodec's scale, 2 is the best: 10 to 20 kB for a street.
_QUALITY = "6"


class TakenPicture(NamedTuple):
    stamp_ns: int
    jpeg: bytes


class PictureTaker:
    """`offer` is called by the camera's thread; `until_ns` is set and `newest` read by another one."""

    def __init__(self, is_coarse: bool) -> None:
        """is_coarse: in blocks that show no face and no plate, as copies that leave the vehicle."""
        self._is_coarse = is_coarse
        self._last_ns: int | None = None
        self._resize: Any = None
        self.until_ns = 0
        self.newest: TakenPicture | None = None

    def offer(self, stamp_ns: int, frame: Any) -> None:
        """frame: planar, of the size that is recorded."""
        if stamp_ns >= self.until_ns:
            self.newest = None
            return
        if self._last_ns is not None and 0 <= stamp_ns - self._last_ns < EVERY_NS:
            return
        self._last_ns = stamp_ns
        try:
            jpeg = self._jpeg(frame)
        except pyav().FFmpegError as error:
            # The recording goes on, and the page says how old its last picture is.
            log.error("video.no_jpeg", error=str(error))
            return
        if len(jpeg) <= PICTURE_BYTES_MAX:
            self.newest = TakenPicture(stamp_ns, jpeg)

    def _jpeg(self, frame: Any) -> bytes:
        av = pyav()
        if self._resize is None:
            self._resize = tuple(av.video.reformatter.VideoReformatter() for _ in range(2))
        to_small, to_shown = self._resize
        width = min(frame.width, WIDTH_PX_MAX)
        height = frame.height * width // frame.width // 2 * 2
        if self._is_coarse:
            blocks = max(2, frame.width // BLOCK_PX), max(2, frame.height // BLOCK_PX)
            frame = to_small.reformat(frame, *blocks, "yuv420p", interpolation="AREA")
        shown = to_shown.reformat(frame, width, height, "yuvj420p", interpolation="BILINEAR")
        shown.pts = None
        codec = av.CodecContext.create("mjpeg", "w")
        codec.width, codec.height, codec.pix_fmt = width, height, "yuvj420p"
        codec.time_base = Fraction(1, 1000)
        codec.options = {"qmin": _QUALITY, "qmax": _QUALITY}
        return b"".join(bytes(packet) for packet in (*codec.encode(shown), *codec.encode(None)))
