"""Campus maps: stored, decoded, drawn and made of files."""

from collections.abc import Collection, Mapping
from datetime import datetime
from pathlib import Path
from typing import Literal, Protocol

from contract.localization_manifest import LocalizationMapKind
from contract.roads.model import RoadMap
from server.domain.roads.closures import Closure
from server.domain.roads.localization_maps import LocalizationMap
from server.domain.roads.maps import ActiveMap, MapDraft, MapVersion, StoredMap
from server.travel.fleet_roads import FleetRoads


class MapLibrary(Protocol):
    """Decoded maps, each kept for the life of the process: a version never changes."""

    def known(self, map_version: str) -> FleetRoads | None: ...

    def decode(self, content: bytes) -> FleetRoads:
        """Raises MapInvalid."""
        ...


class ClosureRepository(Protocol):
    def get(self, closure_id: str) -> Closure | None: ...

    def standing(self) -> tuple[Closure, ...]:
        """Scheduled or in force, by beginning."""
        ...

    def add(self, closure: Closure) -> None: ...

    def save(self, closure: Closure) -> None: ...


class MapRepository(Protocol):
    def get(self, map_version: str) -> StoredMap | None: ...

    def active_version(self) -> str | None: ...

    def active(self) -> ActiveMap: ...

    def versions(self) -> tuple[MapVersion, ...]:
        """All stored maps, the newest first."""
        ...

    def add(self, stored: StoredMap) -> None: ...

    def activate(self, map_version: str) -> None: ...


class LocalizationMapRepository(Protocol):
    """Manifests, and which tiles are kept. The tiles' bytes are in the tile store."""

    def get(self, map_version: str) -> LocalizationMap | None: ...

    def manifest(self, map_version: str) -> bytes | None: ...

    def all(self) -> tuple[LocalizationMap, ...]:
        """The newest first."""
        ...

    def in_force(self) -> Mapping[LocalizationMapKind, LocalizationMap]: ...

    def add(self, stored: LocalizationMap, manifest: bytes) -> None: ...

    def save(self, stored: LocalizationMap) -> None: ...

    def remove(self, map_version: str) -> None: ...

    def kept_tiles(self) -> frozenset[str]:
        """SHA-256 of each."""
        ...

    def is_kept(self, sha256: str) -> bool: ...

    def keep_tiles(self, sizes: Mapping[str, int], at: datetime) -> None:
        """sizes: of tiles whose bytes are in the tile store now, in bytes by SHA-256."""
        ...

    def forget_tiles(self, sha256s: Collection[str]) -> None: ...


class MapDraftRepository(Protocol):
    def get(self, draft_id: str) -> MapDraft | None: ...

    def all(self) -> tuple[MapDraft, ...]:
        """By the newest change, without content."""
        ...

    def add(self, draft: MapDraft) -> None: ...

    def save(self, draft: MapDraft) -> None: ...

    def remove(self, draft_id: str) -> None: ...


ExportFormat = Literal["geojson", "lanelet2", "map"]


class MapWorkshop(Protocol):
    """Makes maps of files and files of maps; all of it takes seconds and blocks."""

    def imported(self, path: Path, like: RoadMap | None, campus_id: str) -> tuple[RoadMap, tuple[str, ...]]:
        """(the map of a file in any known format, what was repaired and left out).

        like  whose name and timezone a file that names none gets. Raises MapInvalid with what to do.
        """
        ...

    def completed(self, road_map: RoadMap) -> RoadMap:
        """A drawn map with sections, and with resting places where it can have them."""
        ...

    def exported(self, road_map: RoadMap, kind: ExportFormat) -> bytes: ...

    def mends(self, code: str) -> bool:
        """Problems of this code can be mended by `mended`."""
        ...

    def mended(self, road_map: RoadMap, code: str, where: str) -> RoadMap:
        """The map without that problem, as far as it can be mended. Raises NoSuchFix."""
        ...
