"""How many events of each boot are stored, in memory; new events are written when the transaction ends."""

from sqlalchemy import Connection

from server.domain.record.events import RecordedEvent
from server.store.cache.memory import RowCache
from server.store.record.events import SqlEventRepository
from server.store.writing.campus_lock import CampusLock

_COUNTS = "event counts"
# Boots of long ago are forgotten all together.
_BOOTS_MAX = 50_000


class CachedEventRepository(SqlEventRepository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock, memory: RowCache) -> None:
        super().__init__(connection, campus_id, lock)
        self._memory = memory
        self._new: list[RecordedEvent] = []

    def count(self, vehicle_id: str, boot_id: str) -> int:
        boot = vehicle_id, boot_id
        known: int | None = self._memory.table(_COUNTS).get(boot)
        if known is None:
            known = super().count(vehicle_id, boot_id)
            self._keep(boot, known)
        return known

    def add(self, event: RecordedEvent) -> None:
        self._new.append(event)
        self._keep((event.vehicle_id, event.boot_id), event.sequence + 1)

    def skip_to(self, vehicle_id: str, boot_id: str, next_sequence: int) -> None:
        super().skip_to(vehicle_id, boot_id, next_sequence)
        self._keep((vehicle_id, boot_id), next_sequence)

    def flush(self) -> None:
        new, self._new = self._new, []
        self._write(new)
        super().flush()

    def _keep(self, boot: tuple[str, str], count: int) -> None:
        if len(self._memory.table(_COUNTS)) >= _BOOTS_MAX and not self._new:
            self._memory.unload(_COUNTS)
            self._memory.table(_COUNTS)
        self._memory.put(_COUNTS, boot, count)
