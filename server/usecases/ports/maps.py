"""Campus maps: stored, and decoded."""

from typing import Protocol

from server.domain.roads.closures import Closure
from server.domain.roads.maps import ActiveMap, StoredMap
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

    def add(self, stored: StoredMap) -> None: ...

    def activate(self, map_version: str) -> None: ...
