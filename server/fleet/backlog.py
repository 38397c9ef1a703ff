"""Events that a hello announces and that are not stored yet; orders wait for them."""

from collections.abc import Iterable, Mapping

from contract.wire.messages import EventLogState

# After this time a vehicle that does not send its announced events gets its order all the same.
PATIENCE_NS = 5_000_000_000


class Backlog:
    """Begins with the logs of a hello, and shrinks with each stored event."""

    __slots__ = ("_until_ns", "_wanted")

    def __init__(self) -> None:
        self._wanted: dict[str, int] = {}
        self._until_ns = 0

    @property
    def is_waiting(self) -> bool:
        return bool(self._wanted)

    def begin(self, logs: Iterable[EventLogState], acknowledged: Mapping[str, int], now_ns: int) -> None:
        """acknowledged: how many events of each boot are stored already."""
        self._wanted = {
            log.boot_id: log.next_sequence
            for log in logs
            if log.next_sequence > acknowledged.get(log.boot_id, 0)
        }
        self._until_ns = now_ns + PATIENCE_NS

    def stored(self, boot_id: str, next_sequence: int) -> bool:
        """Every event of the boot below next_sequence is stored; True when that was the last one awaited."""
        wanted = self._wanted.get(boot_id)
        if wanted is None or wanted > next_sequence:
            return False
        del self._wanted[boot_id]
        return not self._wanted

    def holds_back(self, now_ns: int) -> bool:
        if self._wanted and now_ns >= self._until_ns:
            self._wanted.clear()
        return bool(self._wanted)
