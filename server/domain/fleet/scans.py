"""Requests for lidar scans of an area, what vehicles have kept and sent for them, and proposed point maps."""

from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Literal

from contract.wire.scans import ScanState

EndReason = Literal["", "operator", "time", "size"]
ProposalState = Literal["queued", "building", "stopped", "failed", "ready", "published", "dismissed"]
Corner = tuple[float, float]

# A child process tells its progress every second; a server that says nothing for so long has ended.
SILENT_AFTER = timedelta(seconds=60)


@dataclass(frozen=True, slots=True)
class ScanRequest:
    """An operator wants scans of an area, until a time or a size.

    outline    corners, map frame; none: the whole campus
    every_m    of the way, from one scan to the next
    bytes_max  of all vehicles together
    """

    campus_id: str
    request_id: str
    name: str
    outline: tuple[Corner, ...]
    every_m: float
    bytes_max: int
    until: datetime
    started_at: datetime
    started_by: str
    ended_at: datetime | None = None
    ended_by: str = ""
    end_reason: EndReason = ""

    def is_open_at(self, now: datetime) -> bool:
        return self.ended_at is None and now < self.until


@dataclass(frozen=True, slots=True)
class ScanContribution:
    """What a vehicle said last about a request, and when."""

    request_id: str
    vehicle_id: str
    state: ScanState | Literal["old_agent"]
    detail: str
    scans: int
    way_m: float
    bytes_kept: int
    reported_at: datetime


@dataclass(frozen=True, slots=True)
class ScanParcel:
    """A file of scans that a vehicle has sent; its bytes are in a store by their hash."""

    campus_id: str
    sha256: str
    request_id: str
    vehicle_id: str
    drive_id: str
    number: int
    scans: int
    way_m: float
    size_bytes: int
    received_at: datetime


@dataclass(frozen=True, slots=True)
class MapProposal:
    """A point map that is made of a request's scans, for an operator to publish or to dismiss.

    stage, percent  of the work, as the child process says
    beat_at         when the server that makes it last said so
    result_sha256   of the ZIP file with the map, its figures and its picture; "" before it is ready
    comparison      `contract.scan_parcels.proposals.Comparison` as JSON; "" before it is ready
    """

    campus_id: str
    proposal_id: str
    request_id: str
    started_at: datetime
    started_by: str
    state: ProposalState = "queued"
    stage: str = ""
    percent: int = 0
    beat_at: datetime | None = None
    detail: str = ""
    result_sha256: str = ""
    comparison: str = ""
    decided_at: datetime | None = None
    decided_by: str = ""
    note: str = ""

    @property
    def is_under_way(self) -> bool:
        return self.state in ("queued", "building")

    def is_silent_at(self, now: datetime) -> bool:
        return self.state == "building" and self.beat_at is not None and now - self.beat_at > SILENT_AFTER


def failed(proposal: MapProposal, detail: str) -> MapProposal:
    return replace(proposal, state="failed", detail=detail)
