"""Operators by name: who there is, and which roles each has. Admins change them."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import timedelta

from server.domain.errors import LastAdmin, NameTaken, OperatorUnknown
from server.domain.record.identity import Operator, Role
from server.usecases.ports import topics
from server.usecases.ports.clock_and_ids import PasswordHasher
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.server_events import record_event


@dataclass(frozen=True, slots=True)
class InitialPassword:
    """A password for somebody else, who must change it. It is shown once, and hashed outside transactions."""

    password: str
    hasher: PasswordHasher

    def hashed(self) -> str:
        return self.hasher.hash(self.password)


def initial_password(uow: UnitOfWork) -> InitialPassword:
    return InitialPassword(uow.ids.token(), uow.hasher)


def operator_named(uow: UnitOfWork, name: str) -> Operator:
    """Raises OperatorUnknown."""
    operator = uow.identity.operator_by_name(name)
    if operator is None:
        raise OperatorUnknown("no operator has this name; see GET /operators")
    return operator


def create(uow: UnitOfWork, name: str, roles: Iterable[Role], password_hash: str, by: str) -> Operator:
    """password_hash: of an initial password. Raises NameTaken."""
    if uow.identity.operator_by_name(name) is not None:
        raise NameTaken(f"there is an operator {name} already")
    operator = Operator(
        campus_id=uow.campus_id,
        operator_id=uow.ids.new_id("operator"),
        name=name,
        password_hash=password_hash,
        created_at=uow.now,
        roles=_with_viewer(roles),
        initial_until=uow.now + timedelta(seconds=uow.rules.initial_password_s),
    )
    uow.identity.save_operator(operator)
    record_event(uow, "operator.created", operator.operator_id, by, name)
    return operator


def change(uow: UnitOfWork, name: str, roles: Iterable[Role], *, disabled: bool, by: str) -> Operator:
    """Give an operator these roles, and let them in or not. Takes effect at once, in open sessions as well.

    Raises OperatorUnknown, LastAdmin.
    """
    known = operator_named(uow, name)
    disabled_at = (known.disabled_at or uow.now) if disabled else None
    changed = replace(known, roles=_with_viewer(roles), disabled_at=disabled_at)
    if known.is_admin and not changed.is_admin and not _other_admins(uow, known):
        raise LastAdmin(f"{name} is the last admin; make another operator admin first")
    uow.identity.save_operator(changed)
    if disabled:
        uow.identity.remove_sessions_of(known.operator_id)
    record_event(uow, "operator.changed", known.operator_id, by, " ".join(sorted(changed.roles)))
    uow.publish(topics.access(uow.campus_id))
    return changed


def reset_password(uow: UnitOfWork, name: str, password_hash: str, by: str) -> Operator:
    """An initial password again; the operator's sessions end. Raises OperatorUnknown."""
    initial_until = uow.now + timedelta(seconds=uow.rules.initial_password_s)
    changed = replace(operator_named(uow, name), password_hash=password_hash, initial_until=initial_until)
    uow.identity.save_operator(changed)
    uow.identity.remove_sessions_of(changed.operator_id)
    record_event(uow, "operator.password_reset", changed.operator_id, by)
    uow.publish(topics.access(uow.campus_id))
    return changed


def choose_password(uow: UnitOfWork, operator: Operator, session_sha256: str, password_hash: str) -> Operator:
    """The operator's own choice. Other sessions of the operator end. Raises OperatorUnknown."""
    changed = replace(operator_named(uow, operator.name), password_hash=password_hash, initial_until=None)
    uow.identity.save_operator(changed)
    uow.identity.remove_other_sessions(changed.operator_id, session_sha256)
    record_event(uow, "operator.password_chosen", changed.operator_id, changed.name)
    uow.publish(topics.access(uow.campus_id))
    return changed


def _other_admins(uow: UnitOfWork, operator: Operator) -> bool:
    return any(other.is_admin for other in uow.identity.operators() if other.name != operator.name)


def _with_viewer(roles: Iterable[Role]) -> frozenset[Role]:
    return frozenset(roles) | {"viewer"}
