"""Operators, enrolment codes and developer tokens."""

from collections.abc import Iterable
from dataclasses import dataclass

from server.domain.identity import DeveloperToken, Operator, OperatorSession, Scope
from server.usecases.ports import UnitOfWork


@dataclass(frozen=True, slots=True)
class OpenedSession:
    """token is known to nobody else: it goes into the operator's cookie."""

    token: str
    session: OperatorSession
    operator: Operator


@dataclass(frozen=True, slots=True)
class MadeToken:
    """secret is shown once."""

    secret: str
    token: DeveloperToken


def create_operator(uow: UnitOfWork, name: str, password: str) -> Operator:
    """Raises NameTaken."""
    raise NotImplementedError


def set_password(uow: UnitOfWork, name: str, password: str) -> Operator:
    """Create the operator, or give the one of this name a new password (set-up from the command line)."""
    raise NotImplementedError


def login(uow: UnitOfWork, name: str, password: str) -> OpenedSession:
    """Raises WrongCredentials, after the same work whether the name is known or not."""
    raise NotImplementedError


def logout(uow: UnitOfWork, token: str) -> None:
    """End the session; one that is over already is no error."""
    raise NotImplementedError


def operator_of(uow: UnitOfWork, token: str) -> tuple[Operator, OperatorSession]:
    """Whose session this is. Raises SessionExpired."""
    raise NotImplementedError


def create_enrolment_code(
    uow: UnitOfWork, vehicle_id: str, name: str, by: str, *, seats: int = 6, wheelchair_places: int = 0
) -> str:
    """A code with which the vehicle enrols its key, once; the vehicle is entered if it is new."""
    raise NotImplementedError


def create_developer_token(
    uow: UnitOfWork, name: str, scopes: Iterable[Scope], valid_s: float, by: str
) -> MadeToken:
    raise NotImplementedError


def developer_of(uow: UnitOfWork, secret: str, scope: Scope) -> DeveloperToken:
    """Raises TokenInvalid, ScopeMissing."""
    raise NotImplementedError


def developer_tokens(uow: UnitOfWork) -> tuple[DeveloperToken, ...]:
    """Newest first, revoked and expired ones included."""
    raise NotImplementedError


def revoke_developer_token(uow: UnitOfWork, token_id: str, by: str) -> DeveloperToken:
    """Raises TokenInvalid."""
    raise NotImplementedError
