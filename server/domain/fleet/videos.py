"""Video that vehicles have sent: segments of one camera each, found by vehicle and time."""

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True, slots=True)
class VideoSegment:
    """A file of one camera; its bytes are in a store by their hash.

    begins_at, ends_at  of its first and last picture, by the vehicle's UTC clock, as in its run log
    stamp_ns            of its first picture, by the vehicle's monotonic clock, as in its run log
    """

    campus_id: str
    sha256: str
    vehicle_id: str
    camera: str
    begins_at: datetime
    ends_at: datetime
    stamp_ns: int
    size_bytes: int
    received_at: datetime
