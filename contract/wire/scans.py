"""How a vehicle learns of which areas to keep lidar scans, and how it sends them: a message, a signed PUT."""

from typing import Annotated, Literal

import msgspec

from contract.wire.base import Message
from contract.wire.bounds import Coordinate, Count, Distance, Id, StampNs

# An agent whose hello does not say that it understands this is never sent `ScansRequested`.
SCANS_REQUESTED = "scans_requested"
CORNERS_MAX = 100
REQUESTS_MAX = 20

# What a vehicle does about a request.
ScanState = Literal[
    # it has not been inside the area with a known pose yet
    "waiting",
    # scans are kept and uploaded
    "collecting",
    # the request is over by its time or size, or was ended, and all that was kept is uploaded
    "ended",
    # the disk, or what the vehicle may keep of scans, is full: none are kept until some are uploaded
    "disk_full",
    # the vehicle has no lidar, or it is silent
    "no_scans",
    # the server cannot be reached or refuses what was kept; the vehicle tries again
    "not_uploaded",
    # the process that keeps scans does not answer
    "keeper_silent",
]


class AreaCorner(msgspec.Struct, frozen=True, array_like=True):
    """Map frame."""

    x_m: Coordinate
    y_m: Coordinate


class ScanArea(msgspec.Struct, frozen=True):
    """One request of an operator.

    outline    corners in the map frame, closed implicitly; none: everywhere
    every_m    of the way, from one scan that is kept to the next
    bytes_max  that this vehicle may keep and upload for it
    until_ns   the server's clock
    """

    request_id: Id
    outline: Annotated[tuple[AreaCorner, ...], msgspec.Meta(max_length=CORNERS_MAX)]
    every_m: Distance
    bytes_max: Count
    until_ns: StampNs


class ScansRequested(Message, frozen=True, tag=SCANS_REQUESTED):
    """Server: all open requests for scans. One that is no longer among them is over.

    Sent when a session opens and whenever they change; not acknowledged.
    """

    epoch: Count
    areas: Annotated[tuple[ScanArea, ...], msgspec.Meta(max_length=REQUESTS_MAX)]


def parcel_path(sha256: str) -> str:
    """Where the parcel of this content is PUT (`contract/scan_parcels`); a repeat is harmless."""
    return f"/api/v1/scan-parcels/{sha256}"


def signed_parcel(vehicle_id: str, sha256: str) -> bytes:
    """The bytes that the vehicle's key signs. Bound to the content, so that a copied request adds nothing."""
    return f"campusloop-scans\n{vehicle_id}\n{sha256}".encode()
