"""Copies of the segments that leave the vehicle, in a folder of their own: chosen and coarsened by policy.

What is in the folder may leave; the link uploads it and deletes it. A copy that cannot be made as the policy
wants it is not made.
"""

import os
from pathlib import Path

import msgspec
import structlog

from contract.video import SegmentName
from vehicle_agent.runtime.video.cameras_file import Blur, Upload
from vehicle_agent.runtime.video.coarse import coarsened
from vehicle_agent.runtime.video.disk_room import size_of
from vehicle_agent.runtime.video.segment_names import segments_in
from vehicle_agent.runtime.video.wanted_spans import VideoMark, WantedSpan, wanted, with_mark

log = structlog.get_logger()

# Of copies that wait: a vehicle that is out of reach for days goes on recording.
WAITING_BYTES_MAX = 4 * 1024 * 1024 * 1024


class _Memory(msgspec.Struct):
    """handled: names of segments of which a copy was made, while they exist."""

    spans: tuple[WantedSpan, ...] = ()
    handled: set[str] = set()


class Outgoing:
    """`note` takes marks; `prepare` makes the next copy. What it knows survives a kill."""

    def __init__(self, folder: Path, upload: Upload, blur: Blur) -> None:
        """folder: of the segments. Raises OSError."""
        self._folder, self._upload, self._blur = folder, upload, blur
        self._out, self._file = folder / "outgoing", folder / "wanted.json"
        self._out.mkdir(parents=True, exist_ok=True)
        for part in self._out.glob("*.part"):
            part.unlink()
        try:
            self._memory = msgspec.json.decode(self._file.read_bytes(), type=_Memory)
        except FileNotFoundError:
            self._memory = _Memory()
        except msgspec.DecodeError as error:
            log.error("video.wanted_unreadable", error=str(error))
            self._memory = _Memory()

    def note(self, mark: VideoMark) -> None:
        """Raises OSError."""
        spans = with_mark(self._memory.spans, mark)
        if spans != self._memory.spans:
            self._memory.spans = spans
            self._save()

    def prepare(self) -> SegmentName | None:
        """Makes the copy of the oldest segment that is wanted and has none; None if nothing is to do.

        Raises OSError.
        """
        if self._upload == "never":
            return None
        names = segments_in(self._folder)
        chosen = wanted(names, self._memory.spans) if self._upload == "asked" else names
        left = [
            name for name in chosen if name.length_ms is not None and name.text() not in self._memory.handled
        ]
        if not left or sum(size_of(file) for file in self._out.iterdir()) > WAITING_BYTES_MAX:
            return None
        name = min(left, key=lambda one: (one.utc_ns, one.camera))
        self._copy(name)
        self._memory.handled = {one.text() for one in names} & (self._memory.handled | {name.text()})
        self._save()
        return name

    def _copy(self, name: SegmentName) -> None:
        source, part = self._folder / name.text(), self._out / f"{name.text()}.part"
        if self._blur == "none":
            part.unlink(missing_ok=True)
            os.link(source, part)
        elif not coarsened(source, part):
            part.unlink(missing_ok=True)
            log.error("video.not_coarsened", file=name.text(), consequence="it does not leave the vehicle")
            return
        part.replace(self._out / name.text())

    def _save(self) -> None:
        fresh = self._file.with_suffix(".new")
        fresh.write_bytes(msgspec.json.encode(self._memory))
        fresh.replace(self._file)
