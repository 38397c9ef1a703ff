"""The audit log: entries are appended in the transaction of what they tell."""

from dataclasses import dataclass
from datetime import timedelta
from functools import partial

from server.domain.errors import AuditEntryUnknown
from server.domain.fleet.vehicles import VehicleCommand
from server.domain.record.audit import AuditAction, AuditEntry, Break, Caller, Head, entry_after, first_break
from server.domain.record.events import RecordedEvent
from server.domain.record.runs import Segment
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record.runs import segment_with

ENTRIES_AT_A_TIME = 1_000


@dataclass(frozen=True, slots=True)
class Verdict:
    """broken: where the chain breaks first; head: its last good entry."""

    broken: Break | None
    head: Head


def append(uow: UnitOfWork, caller: Caller, action: AuditAction) -> AuditEntry:
    entry = entry_after(uow.audit.head(), uow.campus_id, uow.now, caller, action, uow.ids.token())
    uow.audit.add(entry)
    return entry


async def verify(transactions: Transactions) -> Verdict:
    """Follow the whole chain, some entries at a time."""
    head = Head()
    while True:
        entries = await transactions.read(partial(_following, number=head.number))
        broken, head = first_break(entries, head)
        if broken is not None or len(entries) < ENTRIES_AT_A_TIME:
            return Verdict(broken, head)


def _following(uow: UnitOfWork, number: int) -> tuple[AuditEntry, ...]:
    return uow.audit.following(number, ENTRIES_AT_A_TIME)


@dataclass(frozen=True, slots=True)
class FollowedEntry:
    """An entry, and how the command ended that it made.

    command  to the vehicle; None if the entry made none
    answer   the vehicle's event, with its boot and clock
    segment  of the vehicle's run log, which has the moment of the answer and its CAN frames
    """

    entry: AuditEntry
    command: VehicleCommand | None = None
    answer: RecordedEvent | None = None
    segment: Segment | None = None


def follow(uow: UnitOfWork, number: int) -> FollowedEntry:
    """From the person to the vehicle's run log. Raises AuditEntryUnknown."""
    found = uow.audit.following(number - 1, 1)
    if not found or found[0].number != number:
        raise AuditEntryUnknown(f"the audit log has no entry {number}")
    entry = found[0]
    command = uow.vehicles.command(entry.action.command_id)
    if command is None:
        return FollowedEntry(entry)
    answer = uow.events.answer_to_command(command.vehicle_id, command.command_id, command.made_at)
    segment = None if answer is None else segment_with(uow, answer)
    return FollowedEntry(entry, command, answer, segment)


def forget_old_addresses(uow: UnitOfWork) -> int:
    """How many entries name no address any longer; the chain stays whole."""
    return uow.audit.forget_addresses_before(uow.now - timedelta(days=uow.rules.audit_address_days))
