"""Sign-in of operators, enrolment codes and developer tokens. `operators` has who may do what."""

import hashlib
import hmac
from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

from server.domain.errors import ScopeMissing, SessionExpired, TokenInvalid, WrongCredentials
from server.domain.fleet.vehicles import Vehicle
from server.domain.record.identity import (
    ALL_ROLES,
    DeveloperToken,
    EnrolmentCode,
    Operator,
    OperatorSession,
    Scope,
)
from server.usecases.ports import topics
from server.usecases.ports.clock_and_ids import PasswordHasher
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.server_events import record_event
from server.usecases.record.webhooks.deliveries import disable_of_account


@dataclass(frozen=True, slots=True)
class CreatedSession:
    """token and browser_token are secrets: they are stored only in the operator's cookies.

    browser_token  tells the browser from those in which this operator has never signed in
    """

    token: str
    browser_token: str
    session: OperatorSession
    operator: Operator


@dataclass(frozen=True, slots=True)
class CreatedToken:
    """secret is shown once."""

    secret: str
    token: DeveloperToken


def sha256_of(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()


def csrf_token_of(session_token: str) -> str:
    """The token that a change needs beside the session's cookie: made of it, so that it is stored nowhere."""
    return hmac.digest(session_token.encode(), b"campusloop-csrf", "sha256").hex()


# ---------------------------------------------------------------- operators


def set_password(uow: UnitOfWork, name: str, password: str) -> Operator:
    """Create the first operator, or give the one of this name a new password (set-up from the command line).

    A password that has changed ends the operator's sessions, and is how one gets in again who has lost the
    second factor or the role: it gives all roles, and the second factor is gone.
    """
    known = uow.identity.operator_by_name(name)
    if known is not None and uow.hasher.verify(known.password_hash, password):
        return known
    operator = Operator(
        campus_id=uow.campus_id,
        operator_id=uow.ids.new_id("operator") if known is None else known.operator_id,
        name=name,
        password_hash=uow.hasher.hash(password),
        created_at=uow.now if known is None else known.created_at,
        roles=ALL_ROLES,
    )
    uow.identity.save_operator(operator)
    uow.identity.remove_sessions_of(operator.operator_id)
    uow.second_factors.remove_all(operator.operator_id)
    record_event(uow, "operator.password_set", operator.operator_id, name)
    uow.publish(topics.access(uow.campus_id))
    return operator


@dataclass(frozen=True, slots=True)
class PasswordCheck:
    """A password to compare outside of any transaction: the comparison takes as long as hundreds of bookings.

    operator  None if the name is unknown
    browser   of a browser in which this operator has signed in before, "" for any other
    """

    operator: Operator | None
    hasher: PasswordHasher
    browser: str = ""

    def passed(self, password: str) -> Operator:
        """Raises WrongCredentials, after the same work whether the name is known or not."""
        if self.operator is None:
            self.hasher.hash(password)
        elif self.hasher.verify(self.operator.password_hash, password):
            return self.operator
        raise WrongCredentials("name and password do not fit")


def password_check(uow: UnitOfWork, name: str, browser_token: str = "") -> PasswordCheck:
    operator = uow.identity.operator_by_name(name)
    browser = "" if operator is None else uow.tickets.browser_of(browser_token, _browser_owner(operator))
    return PasswordCheck(operator, uow.hasher, browser)


def _browser_owner(operator: Operator) -> str:
    """With the password: after a change, its browsers count as new."""
    return f"{operator.operator_id} {sha256_of(operator.password_hash)}"


def open_operator_session(uow: UnitOfWork, operator: Operator) -> CreatedSession:
    """operator: with the password that was compared.

    Raises WrongCredentials if it has changed meanwhile, if it was an initial one that is over, or if the
    operator is disabled.
    """
    known = uow.identity.operator(operator.operator_id)
    if known is None or known.password_hash != operator.password_hash or not _may_sign_in(known, uow.now):
        raise WrongCredentials("name and password do not fit")
    token = uow.ids.token()
    session = OperatorSession(
        campus_id=uow.campus_id,
        token_sha256=sha256_of(token),
        operator_id=operator.operator_id,
        opened_at=uow.now,
        expires_at=uow.now + timedelta(seconds=uow.rules.operator_session_s),
    )
    uow.identity.add_operator_session(session)
    record_event(uow, "operator.logged_in", operator.operator_id, operator.name)
    browser_token = uow.tickets.browser_token(uow.ids.token(), _browser_owner(operator))
    return CreatedSession(token, browser_token, session, operator)


def _may_sign_in(operator: Operator, now: datetime) -> bool:
    return operator.disabled_at is None and (operator.initial_until is None or now < operator.initial_until)


def logout(uow: UnitOfWork, token: str) -> None:
    """End the session; one that is over already is no error."""
    uow.identity.remove_operator_session(sha256_of(token))
    uow.publish(topics.access(uow.campus_id))


def operator_of(uow: UnitOfWork, token: str) -> tuple[Operator, OperatorSession]:
    """Whose session this is. Raises SessionExpired."""
    session = uow.identity.operator_session(sha256_of(token))
    if session is None or session.expires_at <= uow.now:
        raise SessionExpired("your session is over; log in again")
    operator = uow.identity.operator(session.operator_id)
    if operator is None or operator.disabled_at is not None:
        raise SessionExpired("your account is disabled; ask an admin")
    return operator, session


# ---------------------------------------------------------------- vehicles


def create_enrolment_code(
    uow: UnitOfWork, vehicle_id: str, name: str, by: str, *, seats: int, wheelchair_places: int
) -> str:
    """A code with which the vehicle enrols its key, once; the vehicle is entered if it is new."""
    known = uow.vehicles.get(vehicle_id)
    if known is None:
        uow.vehicles.add(
            Vehicle(uow.campus_id, vehicle_id, name, seats, wheelchair_places, enrolled_at=uow.now)
        )
    elif known.retired:
        uow.vehicles.save(replace(known, retired=False, name=name))
    code = uow.ids.token()
    expires_at = uow.now + timedelta(seconds=uow.rules.enrolment_code_s)
    uow.identity.save_enrolment_code(
        EnrolmentCode(uow.campus_id, sha256_of(code), vehicle_id, by, expires_at)
    )
    record_event(uow, "vehicle.enrolment_code_made", vehicle_id, by)
    return code


# ---------------------------------------------------------------- developers


def create_developer_token(
    uow: UnitOfWork, name: str, scopes: Iterable[Scope], valid_s: float, by: str
) -> CreatedToken:
    """A secret with which a program may read, or also drive."""
    secret = uow.ids.token()
    token = DeveloperToken(
        campus_id=uow.campus_id,
        token_id=uow.ids.new_id("token"),
        name=name,
        token_sha256=sha256_of(secret),
        scopes=frozenset(scopes),
        made_by=by,
        created_at=uow.now,
        expires_at=uow.now + timedelta(seconds=valid_s),
    )
    uow.identity.save_developer_token(token)
    record_event(uow, "token.made", token.token_id, by)
    return CreatedToken(secret, token)


def developer_of(uow: UnitOfWork, secret: str, scope: Scope) -> DeveloperToken:
    """Raises TokenInvalid, ScopeMissing."""
    token = uow.identity.developer_token(sha256_of(secret))
    if token is None or not token.is_valid(uow.now):
        raise TokenInvalid("the token is unknown, expired or revoked; ask an operator for a new one")
    if scope not in token.scopes:
        raise ScopeMissing(f"the token may {', '.join(sorted(token.scopes))} only, not {scope}")
    return token


def revoke_developer_token(uow: UnitOfWork, token_id: str, by: str) -> DeveloperToken:
    """Raises TokenInvalid."""
    token = uow.identity.developer_token_by_id(token_id)
    if token is None:
        raise TokenInvalid(f"there is no token {token_id}")
    revoked = token if token.revoked_at is not None else replace(token, revoked_at=uow.now)
    uow.identity.save_developer_token(revoked)
    record_event(uow, "token.revoked", token_id, by)
    disable_of_account(uow, f"developer:{token_id}", "its developer token was revoked")
    uow.publish(topics.access(uow.campus_id))
    return revoked
