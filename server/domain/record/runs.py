"""Recorded runs: one vehicle, one boot, in segments that are each readable alone."""

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True, slots=True)
class Segment:
    """A piece of a run, named by the hash of its content; the bytes are in a file of that name.

    first_ns, last_ns   the vehicle's clock at its first and last record
    """

    campus_id: str
    vehicle_id: str
    boot_id: str
    number: int
    sha256: str
    size_bytes: int
    first_ns: int
    last_ns: int
    received_at: datetime


@dataclass(frozen=True, slots=True)
class Run:
    """One vehicle from its boot on. `started_at` is the server's clock at the boot's first session."""

    campus_id: str
    vehicle_id: str
    boot_id: str
    started_at: datetime
    software: str
    stack: str
    map_version: str
    segments: tuple[Segment, ...] = ()
