"""Video of a vehicle's cameras as both sides know it: what a segment is named, and how it is uploaded.

A segment's file name is its entry in the index: camera, run's time, UTC, length.
`front-0000012345678901-1764160000123456789-00060000.webm` began at 12345678901 ns of the vehicle's monotonic
clock, which is the `stamp_ns` of its run log. One that is still written, or that a kill left, ends in
`.open.webm` and has no length. There is no other index that a crash could leave behind.
"""

import re
from collections.abc import Iterable

import msgspec

# Request header: the segment's name.
SEGMENT_HEADER = "Video-Segment"
CAMERA = r"[a-z][a-z0-9_]{0,30}"
_NAME = re.compile(rf"({CAMERA})-([0-9]{{16,19}})-([0-9]{{16,19}})(?:-([0-9]{{8,10}})|(\.open))\.webm")
# Every WebM file begins with it (EBML, RFC 8794).
WEBM_BEGINS = b"\x1a\x45\xdf\xa3"


class SegmentName(msgspec.Struct, frozen=True):
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
    found = _NAME.fullmatch(text)
    if found is None:
        return None
    camera, stamp, utc, length, _ = found.groups()
    name = SegmentName(camera, int(stamp), int(utc), None if length is None else int(length))
    return name if name.text() == text else None


def overlapping(names: Iterable[SegmentName], from_utc_ns: int, to_utc_ns: int) -> list[SegmentName]:
    """Finished segments with a picture between the two moments, both included."""
    return [
        name
        for name in names
        if name.length_ms is not None and name.utc_ns <= to_utc_ns and name.end_utc_ns >= from_utc_ns
    ]


def video_path(sha256: str) -> str:
    """Where the segment of this content is PUT; a repeat is harmless."""
    return f"/api/v1/video-segments/{sha256}"


def signed_video(vehicle_id: str, sha256: str, name: str) -> bytes:
    """The bytes that the vehicle's key signs, bound to content and name: a copied request adds nothing."""
    return f"campusloop-video\n{vehicle_id}\n{sha256}\n{name}".encode()
