"""Incidents, recorded runs, identities, answers to commands, and leases."""

from collections.abc import Sequence
from datetime import datetime
from typing import Protocol

from server.domain.record.answers import KeyedRequest, StoredAnswer
from server.domain.record.audit import AuditEntry, Head
from server.domain.record.events import ServerEvent
from server.domain.record.identity import DeveloperToken, EnrolmentCode, Operator, OperatorSession, VehicleKey
from server.domain.record.incidents import Incident, IncidentKind
from server.domain.record.recordings import Recording
from server.domain.record.runs import Run, Segment
from server.domain.record.second_factors import SecondFactor
from server.domain.record.webhooks import Webhook
from server.domain.service.announcements import Announcement

# When it was made, and its id.
AnnouncementPosition = tuple[datetime, str]
# When it was started, and its id.
RecordingPosition = tuple[datetime, str]


class IncidentRepository(Protocol):
    def get(self, incident_id: str) -> Incident | None: ...

    def open_about(self, kind: IncidentKind, subject: str) -> Incident | None: ...

    def all_open(self) -> tuple[Incident, ...]:
        """Most urgent first, then oldest."""
        ...

    def about_rides(self, ride_ids: Sequence[str]) -> tuple[Incident, ...]:
        """Open and closed ones of these rides."""
        ...

    def add(self, incident: Incident) -> None: ...

    def save(self, incident: Incident) -> None: ...


class RunRepository(Protocol):
    def get(self, vehicle_id: str, boot_id: str) -> Run | None: ...

    def add(self, run: Run) -> None: ...

    def segment(self, sha256: str) -> Segment | None: ...

    def add_segment(self, segment: Segment) -> None: ...


class AnnouncementRepository(Protocol):
    def get(self, announcement_id: str) -> Announcement | None: ...

    def standing(self, now: datetime) -> tuple[Announcement, ...]:
        """Scheduled or current, by beginning."""
        ...

    def newest(self, limit: int, after: AnnouncementPosition | None = None) -> tuple[Announcement, ...]:
        """Newest first, those that are over included."""
        ...

    def add(self, announcement: Announcement) -> None: ...

    def save(self, announcement: Announcement) -> None: ...


class RecordingRepository(Protocol):
    def get(self, recording_id: str) -> Recording | None: ...

    def of_command(self, command_id: str) -> Recording | None:
        """The one that this command starts or stops."""
        ...

    def newest_of(self, vehicle_id: str) -> Recording | None: ...

    def newest(
        self, vehicle_id: str | None = None, limit: int = 100, after: RecordingPosition | None = None
    ) -> tuple[Recording, ...]:
        """Newest first."""
        ...

    def of_time(self, vehicle_id: str, since: datetime, until: datetime) -> tuple[Recording, ...]:
        """Those that lie in [since, until) in part, oldest first."""
        ...

    def save(self, recording: Recording) -> None: ...


class IdentityRepository(Protocol):
    def operator(self, operator_id: str) -> Operator | None: ...

    def operator_by_name(self, name: str) -> Operator | None: ...

    def operators(self) -> tuple[Operator, ...]:
        """By name, those that are disabled included."""
        ...

    def save_operator(self, operator: Operator) -> None: ...

    def operator_session(self, token_sha256: str) -> OperatorSession | None: ...

    def add_operator_session(self, session: OperatorSession) -> None: ...

    def mark_checked(self, token_sha256: str, at: datetime) -> None:
        """The second factor was checked in this session."""
        ...

    def remove_operator_session(self, token_sha256: str) -> None: ...

    def remove_sessions_of(self, operator_id: str) -> None: ...

    def remove_other_sessions(self, operator_id: str, token_sha256: str) -> None:
        """All of the operator but this one."""
        ...

    def forget_sessions_before(self, moment: datetime) -> int:
        """How many expired sessions were dropped."""
        ...

    def vehicle_key(self, vehicle_id: str) -> VehicleKey | None: ...

    def save_vehicle_key(self, key: VehicleKey) -> None: ...

    def enrolment_code(self, code_sha256: str) -> EnrolmentCode | None: ...

    def save_enrolment_code(self, code: EnrolmentCode) -> None: ...

    def developer_token(self, token_sha256: str) -> DeveloperToken | None: ...

    def developer_token_by_id(self, token_id: str) -> DeveloperToken | None: ...

    def developer_tokens(self) -> tuple[DeveloperToken, ...]: ...

    def save_developer_token(self, token: DeveloperToken) -> None: ...

    def ticket_key_ids(self) -> tuple[str, ...]:
        """Of the keys that links of this campus were made with, in the order of their first use."""
        ...

    def add_ticket_key(self, key_id: str, at: datetime) -> None: ...


class SecondFactorRepository(Protocol):
    def confirmed(self, operator_id: str) -> SecondFactor | None: ...

    def begun(self, operator_id: str) -> SecondFactor | None:
        """One of which no code was given yet."""
        ...

    def save(self, factor: SecondFactor) -> None: ...

    def remove_begun(self, operator_id: str) -> None: ...

    def remove_all(self, operator_id: str) -> None: ...

    def owners(self) -> frozenset[str]:
        """The ids of all operators with a confirmed one."""
        ...


class AuditRepository(Protocol):
    def head(self) -> Head: ...

    def add(self, entry: AuditEntry) -> None: ...

    def newest(
        self,
        limit: int,
        before: int | None = None,
        by: str | None = None,
        action: str | None = None,
        subject: str | None = None,
    ) -> tuple[AuditEntry, ...]:
        """Newest first; before: a number."""
        ...

    def following(self, number: int, limit: int) -> tuple[AuditEntry, ...]:
        """Those after this number, oldest first."""
        ...

    def forget_addresses_before(self, moment: datetime) -> int:
        """How many addresses were dropped."""
        ...


class AnswerRepository(Protocol):
    def claim(self, request: KeyedRequest, now: datetime) -> StoredAnswer | None:
        """None: the key was free, and this transaction has it now. Otherwise what is stored under it."""
        ...

    def complete(self, request: KeyedRequest, sealed: bytes) -> None:
        """Store the answer under the key that this transaction has claimed."""
        ...

    def forget_accounts(self, accounts: Sequence[str]) -> int:
        """Drop the answers of these accounts; how many there were."""
        ...

    def forget_before(self, moment: datetime) -> int:
        """How many answers were dropped."""
        ...


class WebhookRepository(Protocol):
    def get(self, webhook_id: str) -> Webhook | None: ...

    def all(self) -> tuple[Webhook, ...]:
        """Oldest first."""
        ...

    def save(self, webhook: Webhook) -> None: ...

    def remove(self, webhook_id: str) -> None: ...

    def last_event_number(self) -> int:
        """Of the server's own events, 0 before the first one."""
        ...

    def events_after(
        self, number: int, event_types: Sequence[str], limit: int
    ) -> tuple[tuple[int, ServerEvent], ...]:
        """Events of these types (`noun.verb`, `noun.*`) with their numbers, in order."""
        ...


class LeaseRepository(Protocol):
    def take(self, name: str, holder: str, now: datetime, seconds: float) -> int | None:
        """A fencing token, higher for every new holder; None while another one holds the lease."""
        ...

    def token(self, name: str) -> int:
        """The fencing token of the lease's present or last holder, 0 when it was never held."""
        ...
