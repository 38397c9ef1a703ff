"""Video segments as the use cases see them."""

from datetime import datetime
from typing import Protocol

from server.domain.fleet.videos import VideoSegment


class VideoRepository(Protocol):
    def segment(self, sha256: str) -> VideoSegment | None: ...

    def between(self, vehicle_id: str, begin: datetime, end: datetime) -> tuple[VideoSegment, ...]:
        """With a picture between the two moments, both included; by camera and time."""
        ...

    def received_before(self, moment: datetime, limit: int) -> tuple[VideoSegment, ...]:
        """Oldest first."""
        ...

    def add(self, segment: VideoSegment) -> None: ...

    def remove(self, sha256: str) -> None: ...
