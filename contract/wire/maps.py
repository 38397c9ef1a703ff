"""How a vehicle learns of another map, and how it downloads it: the message, and a signed GET over HTTP."""

from typing import Annotated, Literal

import msgspec

from contract.wire.base import Message
from contract.wire.bounds import Count, Id

# A vehicle of an older protocol does not know the message; its map is changed by hand.
MAPS_SINCE_PROTOCOL = 2
# As JSON. The map of a campus of 2 km has 2 MB.
MAP_BYTES_MAX = 64 * 1024 * 1024

MapBytes = Annotated[int, msgspec.Meta(ge=1, le=MAP_BYTES_MAX)]

# Why a vehicle keeps the map that it has; it tries again by itself.
MapFailure = Literal[
    # the server cannot be reached, breaks off, or refuses
    "not_downloaded",
    # other bytes than were announced
    "damaged",
    # announced bytes that are no map by which this vehicle can drive
    "unsound",
    # the disk has no room for it
    "not_stored",
    # by that map the vehicle stands beside every road
    "off_the_lanes",
]


class MapPublished(Message, frozen=True, tag="map_published"):
    """Server: the map in force. Repeated until the vehicle says hello with it; repeats are harmless.

    sha256, size_bytes  of the map's bytes as `map_path` gives them, without content coding
    """

    epoch: Count
    map_version: Id
    sha256: Id
    size_bytes: MapBytes


def map_path(map_version: str) -> str:
    """Where a vehicle GETs the map; its id and its signature go in headers (`contract.wire.upload`)."""
    return f"/api/v1/maps/{map_version}/vehicle-file"


def signed_map_request(vehicle_id: str, map_version: str) -> bytes:
    """The bytes that the vehicle's key signs. A copied request gives nothing but that map."""
    return f"campusloop-map\n{vehicle_id}\n{map_version}".encode()
