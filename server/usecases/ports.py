"""What the use cases need from outside: stores, a clock, ids. Filled in by `app.py`."""

from typing import Protocol

from server.domain.events import RecordedEvent


class EventStore(Protocol):
    def count(self, vehicle_id: str, boot_id: str) -> int:
        """How many events of this boot are stored: the next sequence expected."""
        ...

    def add(self, event: RecordedEvent) -> None: ...
