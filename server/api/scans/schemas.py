"""Requests for scans and proposed point maps, as operators see them."""

from collections.abc import Sequence
from datetime import datetime
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from contract.geometry import POSITION_M_MAX
from contract.scan_parcels.proposals import Comparison
from contract.wire.scans import CORNERS_MAX
from server.api.formats import FreeText
from server.domain.fleet.scans import (
    MapProposal,
    ProposalState,
    ScanContribution,
    ScanParcel,
    ScanRequest,
)
from server.usecases.fleet.map_proposals import comparison_of

MIB = 1024 * 1024
Metres = Annotated[float, Field(ge=-POSITION_M_MAX, le=POSITION_M_MAX)]
REQUEST_EXAMPLE: JsonDict = {
    "request_id": "scans-4",
    "name": "Library, after the building work",
    "outline": [[0.0, 0.0], [120.0, 0.0], [120.0, 60.0], [0.0, 60.0]],
    "every_m": 0.5,
    "bytes_max": 2 * 1024 * MIB,
    "until": "2026-09-01T20:00:00Z",
    "started_at": "2026-09-01T08:00:00Z",
    "started_by": "ines",
    "state": "open",
    "ended_at": None,
    "ended_by": "",
    "scans": 640,
    "way_m": 318.4,
    "size_bytes": 88_000_000,
    "vehicles": [
        {
            "vehicle_id": "shuttle-1", "state": "collecting", "detail": "",
            "reported_at": "2026-09-01T08:20:00Z", "kept_scans": 700, "kept_way_m": 348.0,
            "kept_bytes": 96_000_000, "drives": 2, "scans": 640, "way_m": 318.4, "size_bytes": 88_000_000,
        }
    ],
}  # fmt: skip
PROPOSAL_EXAMPLE: JsonDict = {
    "proposal_id": "proposal-2",
    "request_id": "scans-4",
    "request_name": "Library, after the building work",
    "state": "ready",
    "stage": "comparison",
    "percent": 100,
    "detail": "",
    "started_at": "2026-09-01T20:05:00Z",
    "started_by": "ines",
    "decided_at": None,
    "decided_by": "",
    "note": "",
    "comparison": None,
}


class NewScanRequest(BaseModel):
    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "name": "Library",
                "outline": [[0.0, 0.0], [120.0, 0.0], [120.0, 60.0]],
                "hours": 12.0,
            }
        },
    )

    name: FreeText = Field(min_length=1)
    outline: list[tuple[Metres, Metres]] = Field(
        [], max_length=CORNERS_MAX, description="Corners in the map frame, m; empty: the whole campus."
    )
    every_m: float = Field(0.5, ge=0.2, le=0.8, description="Of the way, from one scan to the next.")
    bytes_max: int = Field(
        2 * 1024 * MIB, ge=MIB, le=64 * 1024 * MIB, description="The request ends when so much has come."
    )
    hours: float = Field(24.0, gt=0.0, le=24.0 * 14, description="The request ends after this time.")


class ScanVehicle(BaseModel):
    """What one vehicle keeps for a request, as it says, and what of it has come."""

    vehicle_id: str
    state: Literal[
        "waiting",
        "collecting",
        "ended",
        "disk_full",
        "no_scans",
        "not_uploaded",
        "keeper_silent",
        "old_agent",
        "unknown",
    ] = Field(description="`old_agent`: its software cannot keep scans. `unknown`: it has not said anything.")
    detail: str
    reported_at: datetime | None
    kept_scans: int
    kept_way_m: float
    kept_bytes: int
    drives: int
    scans: int
    way_m: float
    size_bytes: int


class ScanRequestView(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": REQUEST_EXAMPLE})

    request_id: str
    name: str
    outline: list[list[float]] = Field(description="Corners x, y; empty: the whole campus.")
    every_m: float
    bytes_max: int
    until: datetime
    started_at: datetime
    started_by: str
    state: Literal["open", "operator", "time", "size"] = Field(description="open, or why it has ended.")
    ended_at: datetime | None
    ended_by: str
    scans: int = Field(description="That have come.")
    way_m: float
    size_bytes: int
    vehicles: list[ScanVehicle]


class ParcelView(BaseModel):
    """A parcel of scans that has come."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {"sha256": 64 * "a", "request_id": "scans-4", "scans": 80, "size_bytes": 8_000_000}
        }
    )

    sha256: str
    request_id: str
    scans: int
    size_bytes: int


class Decision(BaseModel):
    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"note": "New wall is right."}})

    note: FreeText = ""


class TileView(BaseModel):
    """One tile of 32 m; counts are of surface elements, about one each half metre of surface."""

    ix: int
    iy: int
    same: int
    new: int
    moved: int
    gone: int
    unseen: int
    added: int
    changed_ratio: float
    is_changed: bool
    is_added: bool


class ComparisonView(BaseModel):
    """The proposed map beside the one in force."""

    map_version: str
    in_force_version: str = Field(description="Empty: there was none, and nothing is compared.")
    drives: int
    scans: int
    way_m: float
    fix_median_m: float = Field(description="From the drives' GNSS fixes.")
    moving_removed: int = Field(description="Elements of people and cars that are not on the map.")
    shift_m: list[float] = Field(description="x, y and z by which it was laid on the map in force.")
    turn_rad: float
    residual_median_m: float | None = Field(description="Across surfaces that both have.")
    residual_p95_m: float | None
    changed_ratio: float | None = Field(description="Of the surface that can be compared.")
    tiles_changed: int
    tiles_compared: int
    tiles_added: int
    tiles: list[TileView] = Field(description="Those that changed or are added.")
    tiles_of_map: int
    bytes_of_map: int
    notes: list[str] = Field(description="What was left out, and why.")


class ProposalView(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": PROPOSAL_EXAMPLE})

    proposal_id: str
    request_id: str
    request_name: str
    state: ProposalState
    stage: str
    percent: int = Field(description="Of the stage.")
    detail: str = Field(description="Why it was stopped or has failed.")
    started_at: datetime
    started_by: str
    decided_at: datetime | None
    decided_by: str
    note: str
    comparison: ComparisonView | None


def request_view(
    request: ScanRequest,
    state: Literal["open", "operator", "time", "size"],
    contributions: Sequence[ScanContribution],
    parcels: Sequence[ScanParcel],
) -> ScanRequestView:
    said = {one.vehicle_id: one for one in contributions}
    names = sorted({*said, *(one.vehicle_id for one in parcels)})
    return ScanRequestView(
        request_id=request.request_id,
        name=request.name,
        outline=[list(corner) for corner in request.outline],
        every_m=request.every_m,
        bytes_max=request.bytes_max,
        until=request.until,
        started_at=request.started_at,
        started_by=request.started_by,
        state=state,
        ended_at=request.ended_at,
        ended_by=request.ended_by,
        scans=sum(one.scans for one in parcels),
        way_m=sum(one.way_m for one in parcels),
        size_bytes=sum(one.size_bytes for one in parcels),
        vehicles=[
            _vehicle(name, said.get(name), [one for one in parcels if one.vehicle_id == name])
            for name in names
        ],
    )


def _vehicle(name: str, said: ScanContribution | None, parcels: Sequence[ScanParcel]) -> ScanVehicle:
    return ScanVehicle(
        vehicle_id=name,
        state="unknown" if said is None else said.state,
        detail="" if said is None else said.detail,
        reported_at=None if said is None else said.reported_at,
        kept_scans=0 if said is None else said.scans,
        kept_way_m=0.0 if said is None else said.way_m,
        kept_bytes=0 if said is None else said.bytes_kept,
        drives=len({one.drive_id for one in parcels}),
        scans=sum(one.scans for one in parcels),
        way_m=sum(one.way_m for one in parcels),
        size_bytes=sum(one.size_bytes for one in parcels),
    )


def proposal_view(proposal: MapProposal, request_name: str) -> ProposalView:
    comparison = comparison_of(proposal)
    return ProposalView(
        proposal_id=proposal.proposal_id,
        request_id=proposal.request_id,
        request_name=request_name,
        state=proposal.state,
        stage=proposal.stage,
        percent=proposal.percent,
        detail=proposal.detail,
        started_at=proposal.started_at,
        started_by=proposal.started_by,
        decided_at=proposal.decided_at,
        decided_by=proposal.decided_by,
        note=proposal.note,
        comparison=None if comparison is None else _comparison_view(comparison),
    )


def _comparison_view(comparison: Comparison) -> ComparisonView:
    tiles = comparison.tiles
    shown = [tile for tile in tiles if tile.is_changed or tile.is_added]
    fields = set(TileView.model_fields)
    return ComparisonView(
        **{
            name: getattr(comparison, name)
            for name in comparison.__struct_fields__
            if name not in ("shift_m", "tiles", "notes")
        },
        shift_m=list(comparison.shift_m),
        tiles_changed=sum(tile.is_changed for tile in tiles),
        tiles_compared=sum(not tile.is_added for tile in tiles),
        tiles_added=sum(tile.is_added and tile.is_remade for tile in tiles),
        tiles=[TileView(**{name: getattr(tile, name) for name in fields}) for tile in shown],
        notes=list(comparison.notes),
    )
