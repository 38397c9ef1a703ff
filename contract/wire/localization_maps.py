"""How a vehicle learns of another localization map, and how it downloads it: a message, and signed GETs.

A vehicle says in its hello by which kind of map it localizes, and is told of maps of that kind alone. An
older agent says none.
"""

from typing import Annotated, Literal

import msgspec

from contract.localization_manifest import MANIFEST_BYTES_MAX, LocalizationMapKind
from contract.wire.base import Message
from contract.wire.bounds import Count, Id

ManifestBytes = Annotated[int, msgspec.Meta(ge=1, le=MANIFEST_BYTES_MAX)]
# "": compares no scans with a map.
LocalizesBy = LocalizationMapKind | Literal[""]

# Why a vehicle keeps the localization map that it has; it tries again by itself.
LocalizationMapFailure = Literal[
    # the server cannot be reached, breaks off, or refuses
    "not_downloaded",
    # other bytes than were announced, or a tile that is not the one of the manifest
    "damaged",
    # announced bytes that are no map which this vehicle can compare its scans with
    "unsound",
    # it lies in another frame than the road map by which the vehicle drives
    "elsewhere",
    # the disk has no room for it
    "not_stored",
]


class LocalizationMapPublished(Message, frozen=True, tag="localization_map_published"):
    """Server: the localization map in force. Repeated until the vehicle says hello with it.

    sha256, size_bytes  of the manifest as `localization_manifest_path` gives it, without content coding
    """

    epoch: Count
    kind: LocalizationMapKind
    map_version: Id
    sha256: Id
    size_bytes: ManifestBytes


def localization_manifest_path(map_version: str) -> str:
    """Where a vehicle GETs the manifest; id and signature go in headers (`contract.wire.upload`)."""
    return f"/api/v1/localization-maps/{map_version}/vehicle-manifest"


def localization_tile_path(map_version: str, sha256: str) -> str:
    """Where a vehicle GETs a tile of that version."""
    return f"/api/v1/localization-maps/{map_version}/vehicle-tiles/{sha256}"


def signed_localization_request(vehicle_id: str, map_version: str) -> bytes:
    """The bytes that the vehicle's key signs, for the manifest and every tile of a version.

    A copied request gives nothing but that map.
    """
    return f"campusloop-localization-map\n{vehicle_id}\n{map_version}".encode()
