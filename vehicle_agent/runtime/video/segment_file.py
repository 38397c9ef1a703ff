"""One video segment on the disk: VP8 in WebM, playable up to its last second after a kill at any time."""

import io
from fractions import Fraction
from pathlib import Path
from typing import Any

import structlog

from contract.video import SegmentName
from vehicle_agent.runtime.video.library import pyav
from vehicle_agent.runtime.video.segment_names import segments_in

log = structlog.get_logger()

# A key frame begins a cluster, which the writer holds back until it is whole: what a kill loses.
KEY_EVERY_MS = 1000
_MS = Fraction(1, 1000)
# Realtime VP8 at its fastest: half the time of speed 8 for 0.3 dB, and less than VP9 (decision 39).
_ENCODER = {"deadline": "realtime", "cpu-used": "16", "lag-in-frames": "0"}
_MUXER = {"cluster_time_limit": str(KEY_EVERY_MS), "flush_packets": "1"}


class SegmentFile:
    """Encodes pictures of one size into one file; `close` gives it its final name."""

    def __init__(
        self, folder: Path, name: SegmentName, size_px: tuple[int, int], rate_hz: float, kbps: int
    ) -> None:
        """size_px: width and height, both even. Raises OSError."""
        av = pyav()
        self._folder, self.name = folder, name
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / name.text()
        self._file: io.FileIO = io.FileIO(self.path, "w+")
        self._container = av.open(self._file, "w", format="webm", options=_MUXER)
        stream = self._container.add_stream("libvpx", rate=Fraction(rate_hz).limit_denominator(1000))
        stream.width, stream.height = size_px
        stream.pix_fmt, stream.bit_rate, stream.options = "yuv420p", kbps * 1000, _ENCODER
        stream.codec_context.time_base, stream.codec_context.thread_count = _MS, 1
        self._stream, self._intra = stream, av.video.frame.PictureType.I
        self._inter = av.video.frame.PictureType.NONE
        self._last_ms, self._key_ms = -1, -KEY_EVERY_MS
        self.pictures = 0

    def add(self, stamp_ns: int, frame: Any) -> None:
        """frame: an `av.VideoFrame` of this size in yuv420p, younger than those before. Raises OSError."""
        at_ms = max((stamp_ns - self.name.stamp_ns) // 1_000_000, self._last_ms + 1)
        frame.pts, frame.time_base = at_ms, _MS
        is_key = at_ms - self._key_ms >= KEY_EVERY_MS
        frame.pict_type = self._intra if is_key else self._inter
        self._container.mux(self._stream.encode(frame))
        self._last_ms, self._key_ms = at_ms, at_ms if is_key else self._key_ms
        self.pictures += 1

    def close(self) -> Path:
        """Finishes it, with its index of key frames. Raises OSError; then it stays as it is, and open."""
        try:
            self._container.mux(self._stream.encode(None))
            self._container.close()
        finally:
            self._file.close()
        return _named(self._folder, self.path, self.name, max(0, self._last_ms))

    def abandon(self) -> None:
        """After an OSError: leaves it as far as it is on the disk."""
        self._file.close()


def _named(folder: Path, path: Path, name: SegmentName, length_ms: int) -> Path:
    final = folder / SegmentName(name.camera, name.stamp_ns, name.utc_ns, length_ms).text()
    path.replace(final)
    return final


def recover(folder: Path) -> list[Path]:
    """Finishes the segments that a killed process left open: the same pictures, with an index and a length.

    One without a single picture is removed. Nothing is encoded again.
    """
    recovered = []
    for path in sorted(folder.glob("*.part")):
        path.unlink()
    for name in segments_in(folder):
        if name.length_ms is not None:
            continue
        path = folder / name.text()
        part = path.with_suffix(".part")
        length_ms = _copied(path, part)
        if length_ms is None:
            part.unlink(missing_ok=True)
            log.warning("video.segment_empty", camera=name.camera, file=path.name)
        else:
            recovered.append(_named(folder, part, name, length_ms))
            log.info("video.segment_recovered", camera=name.camera, length_ms=length_ms)
        path.unlink()
    return recovered


def _copied(path: Path, to: Path) -> int | None:
    """The time of the last picture that can be read, ms; None if there is none."""
    av = pyav()
    last_ms = None
    try:
        with av.open(str(path)) as source, av.open(str(to), "w", format="webm", options=_MUXER) as target:
            video = source.streams.video[0]
            copy = target.add_stream_from_template(video)
            for packet in source.demux(video):
                if packet.dts is None:
                    continue
                at_ms = round(float(packet.pts * packet.time_base) * 1000)
                packet.stream = copy
                target.mux(packet)
                last_ms = at_ms
    except (av.FFmpegError, IndexError):
        # What was read before the damage is kept.
        pass
    return last_ms
