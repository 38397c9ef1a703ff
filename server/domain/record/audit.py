"""The audit log: who did what, when and from where; each entry is chained to the one before by its hash."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Literal

import msgspec

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_MICROSECOND = timedelta(microseconds=1)
FIRST_PREVIOUS = 64 * "0"

CallerKind = Literal["operator", "developer", "vehicle", "server", "unknown"]


@dataclass(frozen=True, slots=True)
class Caller:
    """Who asked for something, and from which address."""

    kind: CallerKind
    name: str
    address: str


@dataclass(frozen=True, slots=True)
class AuditAction:
    """action: the operation's name; subject: ids that it is about; outcome: "done", or the refusal's code.

    detail      the request, or what was given to whom; it names no rider
    command_id  of the command to a vehicle that was made
    """

    action: str
    subject: str = ""
    detail: str = ""
    outcome: str = "done"
    command_id: str = ""


@dataclass(frozen=True, slots=True)
class AuditEntry:
    """An entry as it is stored.

    address, salt  forgotten after a while; address_sha256 is of both, so that the chain stays whole
    sha256         of everything but address and salt, with the hash of the entry before (previous_sha256)
    """

    campus_id: str
    number: int
    happened_at: datetime
    kind: CallerKind
    by: str
    action: AuditAction
    address: str
    salt: str
    address_sha256: str
    previous_sha256: str
    sha256: str


@dataclass(frozen=True, slots=True)
class Head:
    """The end of a chain. Kept elsewhere, it shows later that entries were cut off."""

    number: int = 0
    sha256: str = FIRST_PREVIOUS


@dataclass(frozen=True, slots=True)
class Break:
    """Where a chain is broken, and how that shows."""

    number: int
    what: str


def entry_after(
    head: Head, campus_id: str, at: datetime, caller: Caller, action: AuditAction, salt: str
) -> AuditEntry:
    """The entry that follows `head`. salt: a fresh secret, without which the address cannot be guessed."""
    number, address_sha256 = head.number + 1, _sha256([salt, caller.address])
    content = _content(campus_id, number, at, caller.kind, caller.name, action)
    sha256 = _sha256([*content, address_sha256, head.sha256])
    return AuditEntry(
        campus_id,
        number,
        at,
        caller.kind,
        caller.name,
        action,
        caller.address,
        salt,
        address_sha256,
        head.sha256,
        sha256,
    )


def first_break(entries: Iterable[AuditEntry], head: Head) -> tuple[Break | None, Head]:
    """Follow the chain from `head` on: the first entry that does not belong, and the last good one."""
    for entry in entries:
        what = _what_is_wrong(entry, head)
        if what:
            return Break(entry.number, what), head
        head = Head(entry.number, entry.sha256)
    return None, head


def _what_is_wrong(entry: AuditEntry, head: Head) -> str:
    if entry.number != head.number + 1:
        return f"entries {head.number + 1} to {entry.number - 1} are missing"
    if entry.previous_sha256 != head.sha256:
        return "it does not follow the entry before it"
    content = _content(entry.campus_id, entry.number, entry.happened_at, entry.kind, entry.by, entry.action)
    if _sha256([*content, entry.address_sha256, entry.previous_sha256]) != entry.sha256:
        return "its content was changed"
    if entry.salt and _sha256([entry.salt, entry.address]) != entry.address_sha256:
        return "its address was changed"
    return ""


def _content(
    campus_id: str, number: int, at: datetime, kind: str, by: str, action: AuditAction
) -> list[str | int]:
    microseconds = (at - _EPOCH) // _MICROSECOND
    what = (action.action, action.subject, action.detail, action.outcome, action.command_id)
    return [campus_id, number, microseconds, kind, by, *what]


def _sha256(values: list[str | int]) -> str:
    """Of a JSON array: no two different lists have the same text."""
    return hashlib.sha256(msgspec.json.encode(values)).hexdigest()
