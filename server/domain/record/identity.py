"""Identities: operators, vehicles with their keys, developers. Passengers need no account."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal, get_args

# "infrastructure": a camera that reports presence in an observation area; it may do nothing else.
Scope = Literal["read", "drive", "infrastructure"]

# viewer: looks; dispatcher: rides, roads, shifts, calendars, messages; safety: holds and moves vehicles, lets
# riders out; admin: operators, tokens, enrolments, erasure. Every operator is a viewer.
Role = Literal["viewer", "dispatcher", "safety", "admin"]
ALL_ROLES: frozenset[Role] = frozenset(get_args(Role))


@dataclass(frozen=True, slots=True)
class Operator:
    """An operator by name.

    password_hash   an argon2 string
    initial_until   of a password that was given by somebody else: until then it opens a session, in which
                    nothing can be done but to change it
    """

    campus_id: str
    operator_id: str
    name: str
    password_hash: str
    created_at: datetime
    roles: frozenset[Role]
    disabled_at: datetime | None = None
    initial_until: datetime | None = None

    @property
    def is_admin(self) -> bool:
        """May give access to others, now."""
        return "admin" in self.roles and self.disabled_at is None


@dataclass(frozen=True, slots=True)
class OperatorSession:
    """Only the SHA-256 of the session's token is kept.

    checked_at  when the operator's second factor was last checked in this session
    """

    campus_id: str
    token_sha256: str
    operator_id: str
    opened_at: datetime
    expires_at: datetime
    checked_at: datetime | None = None


@dataclass(frozen=True, slots=True)
class VehicleKey:
    """An Ed25519 public key (32 bytes, base64), enrolled once; revoked keys open nothing."""

    campus_id: str
    vehicle_id: str
    public_key: str
    enrolled_at: datetime
    revoked_at: datetime | None = None


@dataclass(frozen=True, slots=True)
class EnrolmentCode:
    """Lets one vehicle enrol its key, once."""

    campus_id: str
    code_sha256: str
    vehicle_id: str
    made_by: str
    expires_at: datetime
    used_at: datetime | None = None


@dataclass(frozen=True, slots=True)
class DeveloperToken:
    """Only the SHA-256 of the token is kept."""

    campus_id: str
    token_id: str
    name: str
    token_sha256: str
    scopes: frozenset[Scope]
    made_by: str
    created_at: datetime
    expires_at: datetime
    revoked_at: datetime | None = None

    def is_valid(self, now: datetime) -> bool:
        return self.revoked_at is None and now < self.expires_at
