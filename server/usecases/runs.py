"""Recorded runs as vehicles upload them, segment by segment."""

from server.domain.runs import Segment
from server.usecases.ports import UnitOfWork


def add_segment(uow: UnitOfWork, segment: Segment) -> bool:
    """Enter a segment whose bytes are stored already; False for a repeat.

    Raises VehicleUnknown, SegmentConflict.
    """
    raise NotImplementedError


def segment_of(uow: UnitOfWork, sha256: str) -> Segment:
    """Raises SegmentUnknown."""
    raise NotImplementedError
