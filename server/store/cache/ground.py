"""The active maps, closures and travel time factors, in memory: they change seldom."""

from collections.abc import Mapping

from sqlalchemy import Connection

from contract.localization_manifest import LocalizationMapKind
from server.domain.planning.travel_time_factors import TravelTimeFactors
from server.domain.roads.closures import Closure
from server.domain.roads.localization_maps import LocalizationMap
from server.domain.roads.maps import ActiveMap
from server.store.cache.memory import RowCache
from server.store.planning.travel_time_factors import SqlTravelTimeFactorRepository
from server.store.roads.closures import SqlClosureRepository
from server.store.roads.localization_maps import SqlLocalizationMapRepository
from server.store.roads.maps import SqlMapRepository
from server.store.writing.campus_lock import CampusLock

_ACTIVE_MAP, _CLOSURES, _LOCALIZATION_MAPS = "active map", "closures", "localization maps"


class CachedMapRepository(SqlMapRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def active(self) -> ActiveMap:
        known = self._memory.table(_ACTIVE_MAP, lambda: {"": SqlMapRepository.active(self)})
        active: ActiveMap = known[""]
        return active

    def activate(self, map_version: str) -> None:
        super().activate(map_version)
        self._memory.unload(_ACTIVE_MAP)


class CachedLocalizationMapRepository(SqlLocalizationMapRepository):
    """Those in force are asked for before every message to a vehicle."""

    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def in_force(self) -> Mapping[LocalizationMapKind, LocalizationMap]:
        known = self._memory.table(
            _LOCALIZATION_MAPS, lambda: {"": SqlLocalizationMapRepository.in_force(self)}
        )
        in_force: Mapping[LocalizationMapKind, LocalizationMap] = known[""]
        return in_force

    def save(self, stored: LocalizationMap) -> None:
        super().save(stored)
        self._memory.unload(_LOCALIZATION_MAPS)


class CachedClosureRepository(SqlClosureRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def standing(self) -> tuple[Closure, ...]:
        known = self._memory.table(_CLOSURES, lambda: {"": SqlClosureRepository.standing(self)})
        standing: tuple[Closure, ...] = known[""]
        return standing

    def add(self, closure: Closure) -> None:
        super().add(closure)
        self._changed()

    def save(self, closure: Closure) -> None:
        super().save(closure)
        self._changed()

    def _changed(self) -> None:
        self._memory.unload(_CLOSURES)
        self._memory.unload(_ACTIVE_MAP)


class CachedTravelTimeFactorRepository(SqlTravelTimeFactorRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory

    def save(self, factors: TravelTimeFactors) -> None:
        super().save(factors)
        self._memory.unload(_ACTIVE_MAP)
