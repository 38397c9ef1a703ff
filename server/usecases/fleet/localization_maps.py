"""Localization maps: published with a manifest and tiles, put in force, announced to vehicles, removed.

A version is stored by its manifest. Then the tiles that the server lacks are sent, and the version can be put
in force once none is missing. Vehicles that localize by such a map fetch it by themselves.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from contract.localization_manifest import LocalizationManifest, decode_manifest
from contract.localization_maps import LocalizationMapError, is_same_frame
from server.domain.errors import (
    LocalizationMapElsewhere,
    LocalizationMapIncomplete,
    LocalizationMapInForce,
    LocalizationMapInvalid,
    LocalizationMapUnknown,
    LocalizationTileUnknown,
    TooManyLocalizationMaps,
)
from server.domain.record.incidents import IncidentKind
from server.domain.roads.localization_maps import LocalizationMap
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.incidents import clear_incident
from server.usecases.record.server_events import record_event

# Of one campus, of both kinds. Versions that differ in some tiles share the others.
LOCALIZATION_MAPS_MAX = 40


def decoded(manifest: bytes) -> LocalizationManifest:
    """Takes some milliseconds for each thousand tiles. Raises LocalizationMapInvalid."""
    try:
        return decode_manifest(manifest)
    except LocalizationMapError as error:
        raise LocalizationMapInvalid(str(error).rstrip(".")) from error


def store_manifest(
    uow: UnitOfWork, data: bytes, manifest: LocalizationManifest, by: str, note: str = ""
) -> LocalizationMap:
    """Store a version by its manifest, not in force; a repeat gives the stored one.

    manifest  of `data`, as `decoded` gives it
    Raises LocalizationMapElsewhere, TooManyLocalizationMaps, CampusUnknown.
    """
    stored = uow.localization_maps.get(manifest.map_version)
    # A point map's version is a hash of its tiles alone: the same tiles may be said to lie elsewhere.
    if stored is not None and is_same_frame(manifest.origin, stored.origin):
        return stored
    road_map = uow.network().road_map
    if not is_same_frame(manifest.origin, road_map.origin):
        raise LocalizationMapElsewhere(
            _elsewhere(uow, manifest.origin.latitude_deg, manifest.origin.longitude_deg)
        )
    if stored is not None:
        raise LocalizationMapElsewhere(
            f"these tiles are stored with their origin at {stored.origin.latitude_deg:.7f}, "
            f"{stored.origin.longitude_deg:.7f}; remove that version first, if it is wrong"
        )
    if len(uow.localization_maps.all()) >= LOCALIZATION_MAPS_MAX:
        raise TooManyLocalizationMaps(
            f"{LOCALIZATION_MAPS_MAX} localization maps are kept at most; remove one that is no longer needed"
        )
    stored = LocalizationMap(
        campus_id=uow.campus_id,
        map_version=manifest.map_version,
        kind=manifest.kind,
        origin=manifest.origin,
        manifest_sha256=hashlib.sha256(data).hexdigest(),
        manifest_bytes=len(data),
        tile_count=len(manifest.tiles),
        size_bytes=manifest.size_bytes,
        road_map_version=road_map.map_version,
        note=note,
        published_by=by,
        published_at=uow.now,
    )
    uow.localization_maps.add(stored, data)
    record_event(uow, "map.localization_stored", stored.map_version, by, note)
    return stored


def localization_map_of(uow: UnitOfWork, map_version: str) -> LocalizationMap:
    """Raises LocalizationMapUnknown."""
    stored = uow.localization_maps.get(map_version)
    if stored is None:
        raise LocalizationMapUnknown(f"no localization map {map_version} is stored")
    return stored


def manifest_of(uow: UnitOfWork, map_version: str) -> bytes:
    """Raises LocalizationMapUnknown."""
    found = uow.localization_maps.manifest(map_version)
    if found is None:
        raise LocalizationMapUnknown(f"no localization map {map_version} is stored")
    return found


def tile_sizes(uow: UnitOfWork, map_version: str) -> Mapping[str, int]:
    """Bytes of each tile that the manifest names, by SHA-256. Raises LocalizationMapUnknown."""
    return _sizes(manifest_of(uow, map_version))


@lru_cache(maxsize=4)
def _sizes(manifest: bytes) -> Mapping[str, int]:
    """Asked for every tile that is sent."""
    return {tile.sha256: tile.bytes for tile in decode_manifest(manifest).tiles}


def missing_tiles(uow: UnitOfWork, map_version: str) -> tuple[str, ...]:
    """SHA-256 of the tiles whose bytes have not come yet. Raises LocalizationMapUnknown."""
    return tuple(sorted(tile_sizes(uow, map_version).keys() - uow.localization_maps.kept_tiles()))


def require_named(uow: UnitOfWork, map_version: str, sha256: str) -> int:
    """The tile's bytes, by the manifest. Raises LocalizationMapUnknown, LocalizationTileUnknown."""
    size_bytes = tile_sizes(uow, map_version).get(sha256)
    if size_bytes is None:
        raise LocalizationTileUnknown(f"localization map {map_version} names no tile {sha256}")
    return size_bytes


def keep_tiles(uow: UnitOfWork, map_version: str, sha256s: frozenset[str]) -> None:
    """Enter tiles of a stored version whose bytes are in the tile store now.

    Raises LocalizationMapUnknown, LocalizationTileUnknown.
    """
    sizes = tile_sizes(uow, map_version)
    unnamed = sha256s - sizes.keys()
    if unnamed:
        raise LocalizationTileUnknown(f"localization map {map_version} names no tile {min(unnamed)}")
    uow.localization_maps.keep_tiles({sha256: sizes[sha256] for sha256 in sha256s}, uow.now)


def activate(uow: UnitOfWork, map_version: str, by: str) -> LocalizationMap:
    """Put a stored version in force: forward, or back. Every vehicle of its kind learns of it over its link.

    Raises LocalizationMapUnknown, LocalizationMapIncomplete, LocalizationMapElsewhere, CampusUnknown.
    """
    stored = localization_map_of(uow, map_version)
    if stored.active:
        return stored
    missing = missing_tiles(uow, map_version)
    if missing:
        raise LocalizationMapIncomplete(
            f"{len(missing)} of {stored.tile_count} tiles have not come yet; send them first"
        )
    if not is_same_frame(stored.origin, uow.network().road_map.origin):
        raise LocalizationMapElsewhere(
            _elsewhere(uow, stored.origin.latitude_deg, stored.origin.longitude_deg)
        )
    former = uow.localization_maps.in_force().get(stored.kind)
    if former is not None:
        uow.localization_maps.save(replace(former, active=False))
    stored = replace(stored, active=True, activated_by=by, activated_at=uow.now)
    uow.localization_maps.save(stored)
    record_event(uow, "map.localization_activated", map_version, by, stored.note)
    for vehicle in uow.vehicles.all():
        if vehicle.localizes_by == stored.kind:
            clear_incident(uow, IncidentKind.LOCALIZATION_MAP_NOT_CHANGED, vehicle.vehicle_id)
            uow.vehicles.save(replace(vehicle, localization_change=""))
            uow.publish(topics.vehicle_outbox(uow.campus_id, vehicle.vehicle_id))
    return stored


def remove(uow: UnitOfWork, map_version: str, by: str) -> frozenset[str]:
    """Remove a version that is not in force. Returns the SHA-256 of the tiles that no other version names:
    their bytes may be deleted once the transaction is committed.

    Raises LocalizationMapUnknown, LocalizationMapInForce.
    """
    stored = localization_map_of(uow, map_version)
    if stored.active:
        raise LocalizationMapInForce("vehicles localize by this map; put another one in force first")
    unneeded = tile_sizes(uow, map_version).keys() & uow.localization_maps.kept_tiles()
    for other in uow.localization_maps.all():
        if other.map_version != map_version:
            unneeded -= tile_sizes(uow, other.map_version).keys()
    uow.localization_maps.remove(map_version)
    uow.localization_maps.forget_tiles(unneeded)
    record_event(uow, "map.localization_removed", map_version, by, stored.note)
    return frozenset(unneeded)


def _elsewhere(uow: UnitOfWork, latitude_deg: float, longitude_deg: float) -> str:
    here = uow.network().road_map.origin
    return (
        f"the map has its origin at {latitude_deg:.7f}, {longitude_deg:.7f}, and the campus map in force at "
        f"{here.latitude_deg:.7f}, {here.longitude_deg:.7f}; make it again on the map in force"
    )
