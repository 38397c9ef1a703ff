"""What both kinds of segment stores do. Tiles of localization maps are kept in stores of the same kinds."""

from pathlib import Path
from typing import Protocol

from server.store.segments.incoming import IncomingSegment

SEGMENT_ENDING = ".mcap"


class SegmentStoreError(Exception):
    """The store cannot be used now; the message says why. Nothing was stored."""


class SegmentStore(Protocol):
    """Segments, or tiles, by the SHA-256 of their bytes. None is ever changed, and a repeat is harmless."""

    def receive(self, sha256: str, name: str) -> IncomingSegment:
        """Begin an upload. name: unique among the uploads under way."""
        ...

    def has(self, sha256: str) -> bool:
        """May block. Raises SegmentStoreError."""
        ...

    def keep(self, incoming: IncomingSegment) -> None:
        """Store a proven upload for good. May block. Raises SegmentStoreError, OSError."""
        ...

    def fetch(self, sha256: str) -> Path | None:
        """The segment as a file of this machine, to be opened soon; None if it is not kept.

        May block. Raises SegmentStoreError, OSError.
        """
        ...

    def remove(self, sha256: str) -> None:
        """Delete one; what is not kept is no error. May block. Raises SegmentStoreError, OSError."""
        ...


def key_of(sha256: str, ending: str) -> str:
    """Where a segment lies below the store's root; folders of at most 1/256 of all."""
    return f"{sha256[:2]}/{sha256}{ending}"
