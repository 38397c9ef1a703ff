"""Runs and their segments as operators see them."""

from datetime import datetime

from pydantic import BaseModel, ConfigDict

from server.domain.record.runs import Run, Segment

SHA256_EXAMPLE = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"


class SegmentView(BaseModel):
    """first_ns and last_ns are the vehicle's clock at the first and last record."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "number": 0,
                "sha256": SHA256_EXAMPLE,
                "size_bytes": 8_412_004,
                "first_ns": 1_200_000_000,
                "last_ns": 301_180_000_000,
                "received_at": "2026-09-01T08:21:02Z",
            }
        }
    )

    number: int
    sha256: str
    size_bytes: int
    first_ns: int
    last_ns: int
    received_at: datetime


class RunView(BaseModel):
    """One vehicle from one boot on."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "vehicle_id": "shuttle-1",
                "boot_id": "boot-7a1e",
                "started_at": "2026-09-01T08:14:31Z",
                "duration_s": 299.98,
                "software": "0.1.0",
                "stack": "gem",
                "map_version": "3f0c9a71d2e84b55",
                "segments": [],
            }
        }
    )

    vehicle_id: str
    boot_id: str
    started_at: datetime
    duration_s: float
    software: str
    stack: str
    map_version: str
    segments: list[SegmentView]


def run_view(run: Run) -> RunView:
    spans = [(segment.first_ns, segment.last_ns) for segment in run.segments]
    duration_ns = max(last for _, last in spans) - min(first for first, _ in spans) if spans else 0
    return RunView(
        vehicle_id=run.vehicle_id,
        boot_id=run.boot_id,
        started_at=run.started_at,
        duration_s=duration_ns / 1e9,
        software=run.software,
        stack=run.stack,
        map_version=run.map_version,
        segments=[segment_view(segment) for segment in run.segments],
    )


def segment_view(segment: Segment) -> SegmentView:
    return SegmentView(
        number=segment.number,
        sha256=segment.sha256,
        size_bytes=segment.size_bytes,
        first_ns=segment.first_ns,
        last_ns=segment.last_ns,
        received_at=segment.received_at,
    )
