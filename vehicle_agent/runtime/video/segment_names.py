"""A video segment's file name is its entry in the index: camera, run's time, UTC, length.

`front-0000012345678901-1764160000123456789-00060000.webm` began at 12345678901 ns of the vehicle's monotonic
clock, which is the `stamp_ns` of its run log. One that is still written, or that a kill left, ends in
`.open.webm` and has no length. There is no other index that a crash could leave behind.
"""

import re
from collections.abc import Iterable
from pathlib import Path

import msgspec

CAMERA = r"[a-z][a-z0-9_]{0,30}"
_NAME = re.compile(rf"({CAMERA})-(\d{{16,19}})-(\d{{16,19}})(?:-(\d{{8,10}})|(\.open))\.webm$")


class SegmentName(msgspec.Struct, frozen=True, order=True):
    """stamp_ns   of the first picture, monotonic clock of the vehicle, as in its run log
    utc_ns     the same moment by the vehicle's UTC clock
    length_ms  from the first picture to the last; None while it is written
    """

    camera: str
    stamp_ns: int
    utc_ns: int
    length_ms: int | None = None

    def text(self) -> str:
        end = ".open" if self.length_ms is None else f"-{self.length_ms:08d}"
        return f"{self.camera}-{self.stamp_ns:016d}-{self.utc_ns:016d}{end}.webm"

    @property
    def end_utc_ns(self) -> int:
        return self.utc_ns + (self.length_ms or 0) * 1_000_000


def name_of(text: str) -> SegmentName | None:
    """None for a file that is no segment."""
    found = _NAME.match(text)
    if found is None:
        return None
    camera, stamp, utc, length, _ = found.groups()
    return SegmentName(camera, int(stamp), int(utc), None if length is None else int(length))


def segments_in(folder: Path) -> list[SegmentName]:
    """All segments of a folder, by camera and time. A folder that is not there has none."""
    try:
        files = list(folder.iterdir())
    except FileNotFoundError:
        return []
    return sorted_names(name_of(file.name) for file in files)


def sorted_names(names: Iterable[SegmentName | None]) -> list[SegmentName]:
    return sorted(
        (name for name in names if name is not None), key=lambda one: (one.camera, one.stamp_ns, one.utc_ns)
    )


def overlapping(names: Iterable[SegmentName], from_utc_ns: int, to_utc_ns: int) -> list[SegmentName]:
    """Finished segments with a picture between the two moments, both included."""
    return [
        name
        for name in names
        if name.length_ms is not None and name.utc_ns <= to_utc_ns and name.end_utc_ns >= from_utc_ns
    ]
