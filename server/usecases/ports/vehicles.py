"""Vehicles, their positions and history, and their events."""

from collections.abc import Sequence
from datetime import datetime
from typing import Protocol

from contract.wire.messages import CommandKind, Status
from server.domain.fleet.vehicles import StatusReport, Vehicle, VehicleCommand, Whereabouts
from server.domain.record.events import RecordedEvent, ServerEvent


class EventStore(Protocol):
    def count(self, vehicle_id: str, boot_id: str) -> int:
        """How many events of this boot are stored: the next sequence expected."""
        ...

    def add(self, event: RecordedEvent) -> None: ...


class EventRepository(EventStore, Protocol):
    def skip_to(self, vehicle_id: str, boot_id: str, next_sequence: int) -> None:
        """Expect this event next: those before it are lost."""
        ...

    def answer_to_command(self, vehicle_id: str, command_id: str, made_at: datetime) -> RecordedEvent | None:
        """The event with which the vehicle answered a command, if it did within ANSWERED_WITHIN."""
        ...

    def add_server_event(self, event: ServerEvent) -> None: ...

    def erase_details(self, subjects: Sequence[str]) -> None:
        """Empty the details of all events about these subjects; the events stay."""
        ...


class VehicleRepository(Protocol):
    def get(self, vehicle_id: str) -> Vehicle | None: ...

    def all(self) -> tuple[Vehicle, ...]:
        """By vehicle id, retired ones left out."""
        ...

    def add(self, vehicle: Vehicle) -> None: ...

    def save(self, vehicle: Vehicle) -> None: ...

    def whereabouts(self, vehicle_id: str) -> Whereabouts | None: ...

    def all_whereabouts(self) -> tuple[Whereabouts, ...]: ...

    def heard(self, vehicle_id: str, at: datetime) -> None: ...

    def save_position(self, vehicle_id: str, status: Status) -> None:
        """Correct the newest position; the history does not change."""
        ...

    def save_status(self, reports: Sequence[StatusReport]) -> None:
        """The newest of each vehicle becomes its whereabouts; all of them become history."""
        ...

    def add_command(self, command: VehicleCommand) -> None: ...

    def save_command(self, command: VehicleCommand) -> None: ...

    def command(self, command_id: str) -> VehicleCommand | None: ...

    def newest_command(self, vehicle_id: str, kind: CommandKind) -> VehicleCommand | None: ...

    def marks(self, vehicle_id: str, since: datetime, until: datetime) -> tuple[VehicleCommand, ...]:
        """Commands that mark its recording, given in [since, until), oldest first."""
        ...

    def pending_commands(self, vehicle_id: str) -> tuple[VehicleCommand, ...]:
        """Oldest first."""
        ...


class HistoryRepository(Protocol):
    def forget_before(self, moment: datetime) -> int:
        """How many positions were dropped."""
        ...
