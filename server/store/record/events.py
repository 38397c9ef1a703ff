"""Events of vehicles and of the server, append-only."""

from collections.abc import Sequence
from datetime import datetime

import msgspec
import structlog
from sqlalchemy import Connection, select

from contract.wire.messages import CommandDone, VehicleEvent
from server.domain.instants import ns_of
from server.domain.record.events import ANSWERED_WITHIN, RecordedEvent, ServerEvent
from server.store import tables
from server.store.columns import to_json
from server.store.counters import Counters
from server.store.repository import AnyRow, Repository
from server.store.writing.campus_lock import CampusLock

log = structlog.get_logger("store.record")

_event = tables.vehicle_events.c
_EVENT_COLUMNS = ("number", "vehicle_id", "boot_id", "sequence", "stamp_ns", "received_ns", "body")
_decoder: msgspec.json.Decoder[VehicleEvent] = msgspec.json.Decoder(VehicleEvent)


class SqlEventRepository(Repository):
    def __init__(self, connection: Connection, campus_id: str, lock: CampusLock | None) -> None:
        super().__init__(connection, campus_id, lock)
        self._counters = Counters(connection, campus_id, lock)
        self._unwritten: list[ServerEvent] = []

    def count(self, vehicle_id: str, boot_id: str) -> int:
        row = self._find(tables.event_logs, vehicle_id=vehicle_id, boot_id=boot_id)
        return 0 if row is None else int(row.next_sequence)

    def add(self, event: RecordedEvent) -> None:
        self._write((event,))

    def skip_to(self, vehicle_id: str, boot_id: str, next_sequence: int) -> None:
        self._put(
            tables.event_logs,
            {"vehicle_id": vehicle_id, "boot_id": boot_id, "next_sequence": next_sequence},
        )

    def _write(self, events: Sequence[RecordedEvent]) -> None:
        """Events of a boot are given in their order; none was stored before."""
        if not events:
            return
        first = self._counters.next("vehicle_event", len(events))
        rows = [_event_to_row(first + number, event) for number, event in enumerate(events)]
        self._insert_values(tables.vehicle_events, _EVENT_COLUMNS, rows)
        following = {(event.vehicle_id, event.boot_id): event.sequence + 1 for event in events}
        self._put_all(
            tables.event_logs,
            [
                {"vehicle_id": vehicle_id, "boot_id": boot_id, "next_sequence": sequence}
                for (vehicle_id, boot_id), sequence in following.items()
            ],
        )

    def answer_to_command(self, vehicle_id: str, command_id: str, made_at: datetime) -> RecordedEvent | None:
        # Events have no index by command: only those of the time after it are looked through.
        rows = self._connection.execute(
            select(tables.vehicle_events)
            .where(
                _event.campus_id == self._campus_id,
                _event.received_ns >= ns_of(made_at),
                _event.received_ns < ns_of(made_at + ANSWERED_WITHIN),
                _event.vehicle_id == vehicle_id,
                _event.body.contains(command_id, autoescape=True),
            )
            .order_by(_event.received_ns, _event.sequence)
        )
        for row in rows:
            event = recorded_from_row(row)
            body = None if event is None else event.body
            if isinstance(body, CommandDone) and body.command_id == command_id:
                return event
        return None

    def add_server_event(self, event: ServerEvent) -> None:
        self._unwritten.append(event)

    def erase_details(self, subjects: Sequence[str]) -> None:
        self.flush()
        event = tables.server_events.c
        self._update(tables.server_events, {"detail": ""}, event.subject.in_(subjects), event.detail != "")

    def flush(self) -> None:
        """Write the server's own events, when the transaction ends: their numbers are drawn at once."""
        events, self._unwritten = self._unwritten, []
        if not events:
            return
        first = self._counters.next("server_event", len(events))
        self._insert_all(
            tables.server_events,
            [
                {
                    "number": first + number,
                    "happened_at": event.happened_at,
                    "name": event.name,
                    "subject": event.subject,
                    "made_by": event.by,
                    "detail": event.detail,
                }
                for number, event in enumerate(events)
            ],
        )


def _event_to_row(number: int, event: RecordedEvent) -> tuple[str | int, ...]:
    """In the order of _EVENT_COLUMNS."""
    return (
        number,
        event.vehicle_id,
        event.boot_id,
        event.sequence,
        event.stamp_ns,
        event.received_ns,
        to_json(event.body),
    )


def recorded_from_row(row: AnyRow) -> RecordedEvent | None:
    """None for an event that a former version let in and that is no event of this protocol."""
    try:
        body: VehicleEvent = _decoder.decode(row.body)
    except msgspec.DecodeError as error:
        log.error("event.row_invalid", vehicle_id=row.vehicle_id, sequence=row.sequence, what=str(error))
        return None
    return RecordedEvent(row.vehicle_id, row.boot_id, row.sequence, row.stamp_ns, row.received_ns, body)


def server_event_from_row(row: AnyRow) -> ServerEvent:
    return ServerEvent(row.campus_id, row.happened_at, row.name, row.subject, row.made_by, row.detail)
