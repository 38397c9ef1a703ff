"""Publishes a localization map from a folder of this machine, as an upload over HTTP would."""

from pathlib import Path
from uuid import uuid4

from contract.localization_manifest import LocalizationManifest, tile_check
from contract.localization_maps import LocalizationMapError
from server.domain.errors import LocalizationTileInvalid
from server.domain.roads.localization_maps import LocalizationMap
from server.store.segments.segment_store import SegmentStore
from server.usecases.fleet import localization_maps
from server.usecases.ports.offload import Offload
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork

_INDEX = "index.json"


async def store_folder(
    transactions: Transactions, tiles: SegmentStore, offload: Offload, folder: Path, by: str, note: str = ""
) -> LocalizationMap:
    """Store the map of a folder as a complete version that is not in force; a repeat gives the stored one.

    tiles  the store of localization maps' tiles (`Services.tiles`)
    by     who publishes it; note: what it was made of, for operators
    `localization_maps.activate` puts it in force.

    Raises LocalizationMapInvalid, LocalizationTileInvalid, LocalizationMapElsewhere, TooManyLocalizationMaps,
    CampusUnknown, SegmentStoreError, OSError. Then a version may lack tiles: a repeat goes on.
    """
    data = await offload.run((folder / _INDEX).read_bytes)
    manifest = await offload.run(lambda: localization_maps.decoded(data))

    def begin(uow: UnitOfWork) -> tuple[LocalizationMap, tuple[str, ...]]:
        stored = localization_maps.store_manifest(uow, data, manifest, by, note)
        return stored, localization_maps.missing_tiles(uow, stored.map_version)

    stored, missing = await transactions.run(begin)
    if missing:
        wanted = frozenset(missing)
        await offload.run(lambda: _keep_tiles(tiles, folder, data, manifest, wanted))
        await transactions.run(lambda uow: localization_maps.keep_tiles(uow, stored.map_version, wanted))
    return stored


def _keep_tiles(
    tiles: SegmentStore, folder: Path, data: bytes, manifest: LocalizationManifest, wanted: frozenset[str]
) -> None:
    check = tile_check(data)
    for tile in {one.sha256: one for one in manifest.tiles if one.sha256 in wanted}.values():
        content = (folder / tile.file).read_bytes()
        try:
            check(tile.sha256, content)
        except LocalizationMapError as error:
            raise LocalizationTileInvalid(str(error).rstrip(".")) from error
        with tiles.receive(tile.sha256, uuid4().hex) as incoming:
            incoming.write(content)
            incoming.prove()
            tiles.keep(incoming)
