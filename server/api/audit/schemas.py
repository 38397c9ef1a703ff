"""The audit log as admins read it."""

from datetime import datetime

from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from server.domain.instants import moment_of_ns
from server.domain.record.audit import AuditEntry, CallerKind
from server.usecases.record.audit import FollowedEntry, Verdict

ENTRY_EXAMPLE: JsonDict = {
    "number": 4711,
    "happened_at": "2026-09-01T08:14:31Z",
    "kind": "operator",
    "by": "ann",
    "action": "resume_vehicle",
    "subject": "shuttle-1",
    "detail": "POST /api/v1/vehicles/shuttle-1/resume",
    "outcome": "done",
    "command_id": "command-19",
    "address": "192.0.2.7",
    "sha256": "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08",
    "previous_sha256": "2c26b46b68ffc68ff99b453c1d30413413422d706483bfa0f98a5e886266e7ae",
}


class AuditEntryView(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": ENTRY_EXAMPLE})

    number: int
    happened_at: datetime
    kind: CallerKind
    by: str
    action: str = Field(description="The operation's id in this document, or a method of /ws/developer.")
    subject: str
    detail: str
    outcome: str = Field(description="done, or the code of the refusal.")
    command_id: str
    address: str = Field(description="Empty once it is forgotten.")
    sha256: str
    previous_sha256: str


class CommandEnd(BaseModel):
    """How a command to a vehicle ended. Its run log has what the vehicle did, to the CAN frame.

    stamp_ns  of the vehicle's clock, as in its run log
    """

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "command_id": "command-19",
                "vehicle_id": "shuttle-1",
                "kind": "resume",
                "state": "done",
                "reason": "",
                "answered_at": "2026-09-01T08:14:31.400Z",
                "boot_id": "boot-7a1e",
                "stamp_ns": 81200000000,
                "segment_sha256": "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08",
            }
        }
    )

    command_id: str
    vehicle_id: str
    kind: str
    state: str
    reason: str = Field(description="The vehicle's, if it refused.")
    answered_at: datetime | None
    boot_id: str | None = Field(description="The run whose log has it.")
    stamp_ns: int | None
    segment_sha256: str | None = Field(
        description="The segment of the run log, at GET /runs/segments/{sha256}, once it is uploaded."
    )


class FollowedEntryView(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": {"entry": ENTRY_EXAMPLE, "command": None}})

    entry: AuditEntryView
    command: CommandEnd | None


class ChainView(BaseModel):
    """Whether each entry follows the one before. Compare the head with one that was noted earlier."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "intact": True,
                "head_number": 4711,
                "head_sha256": ENTRY_EXAMPLE["sha256"],
                "broken_at": None,
                "what": "",
            }
        }
    )

    intact: bool
    head_number: int = Field(description="The last entry that follows; 0 for none.")
    head_sha256: str
    broken_at: int | None
    what: str


def entry_view(entry: AuditEntry) -> AuditEntryView:
    action = entry.action
    return AuditEntryView(
        number=entry.number,
        happened_at=entry.happened_at,
        kind=entry.kind,
        by=entry.by,
        action=action.action,
        subject=action.subject,
        detail=action.detail,
        outcome=action.outcome,
        command_id=action.command_id,
        address=entry.address,
        sha256=entry.sha256,
        previous_sha256=entry.previous_sha256,
    )


def followed_view(followed: FollowedEntry) -> FollowedEntryView:
    command, answer, segment = followed.command, followed.answer, followed.segment
    end = None
    if command is not None:
        end = CommandEnd(
            command_id=command.command_id,
            vehicle_id=command.vehicle_id,
            kind=command.kind,
            state=command.state,
            reason=command.detail,
            answered_at=None if answer is None else moment_of_ns(answer.received_ns),
            boot_id=None if answer is None else answer.boot_id,
            stamp_ns=None if answer is None else answer.stamp_ns,
            segment_sha256=None if segment is None else segment.sha256,
        )
    return FollowedEntryView(entry=entry_view(followed.entry), command=end)


def chain_view(verdict: Verdict) -> ChainView:
    broken = verdict.broken
    return ChainView(
        intact=broken is None,
        head_number=verdict.head.number,
        head_sha256=verdict.head.sha256,
        broken_at=None if broken is None else broken.number,
        what="" if broken is None else broken.what,
    )
