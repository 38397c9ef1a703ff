"""Developer tokens, made and revoked by an admin who is at the server's machine."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from server.domain.errors import DomainError
from server.domain.record.audit import AuditAction, Caller
from server.domain.record.identity import DeveloperToken, Scope
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import audit, identity

DAY_S = 86_400.0


class NoAdmin(DomainError):
    """The operator in whose name a token is made or revoked is unknown, disabled or no admin."""

    code = "no_admin"


@dataclass(frozen=True, slots=True)
class TokenRequest:
    """user: the admin in whose name it is made."""

    user: str
    name: str
    scopes: frozenset[Scope]
    valid_days: float


def create_token(request: TokenRequest) -> Callable[[UnitOfWork], identity.CreatedToken]:
    """The change; it raises NoAdmin. Enters in the audit log what the API would enter."""
    scopes = sorted(request.scopes)

    def work(uow: UnitOfWork) -> identity.CreatedToken:
        _require_admin(uow, request.user)
        made = identity.create_developer_token(
            uow, request.name, scopes, request.valid_days * DAY_S, request.user
        )
        detail = f"scopes {' '.join(scopes)} for {request.valid_days:g} days"
        audit.append(uow, _caller(request.user), AuditAction("make_token", request.name, detail))
        return made

    return work


def revoke_token(user: str, token_id: str) -> Callable[[UnitOfWork], DeveloperToken]:
    """The change; it raises NoAdmin and TokenInvalid."""

    def work(uow: UnitOfWork) -> DeveloperToken:
        _require_admin(uow, user)
        revoked = identity.revoke_developer_token(uow, token_id, user)
        audit.append(uow, _caller(user), AuditAction("revoke_token", token_id))
        return revoked

    return work


def _require_admin(uow: UnitOfWork, user: str) -> None:
    operator = uow.identity.operator_by_name(user)
    if operator is None or not operator.is_admin:
        admins: Iterable[str] = (one.name for one in uow.identity.operators() if one.is_admin)
        raise NoAdmin(f"{user} is no admin of this campus; its admins are: {', '.join(admins) or 'none'}")


def _caller(user: str) -> Caller:
    """No one has signed in: who may write the database may use any name. So the kind is not `operator`."""
    return Caller("server", user, "command line")
