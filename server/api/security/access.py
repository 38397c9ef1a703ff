"""Access: operators by cookie, CSRF token and role, developers by bearer token; addresses of clients.

Every endpoint names its `Permission` by one of the dependencies made here.
"""

import hmac
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Annotated, Literal

from fastapi import Depends, Request, Security
from fastapi.security import APIKeyCookie, APIKeyHeader, HTTPAuthorizationCredentials, HTTPBearer

from server.addresses import budget_of
from server.api.problems import CsrfMissing
from server.api.security.permissions import LOOK, Permission
from server.api.security.rate_limit import TooManyTries
from server.api.security.request_origin import address_of, operation_of, subject_of, target_of
from server.api.services import InjectedServices, Services
from server.domain.errors import (
    DomainError,
    IdempotencyMismatch,
    PasswordChangeNeeded,
    RoleMissing,
    ScopeMissing,
    SecondFactorMissing,
    SecondFactorNeeded,
    SessionExpired,
    TokenInvalid,
)
from server.domain.instants import ns_of
from server.domain.record.audit import AuditAction, Caller
from server.domain.record.identity import DeveloperToken, Operator, OperatorSession, Scope
from server.usecases.record import audit, identity

SESSION_COOKIE = "campusloop_session"
CSRF_HEADER = "X-CSRF-Token"

SIGNED_OUT = "sign in at POST /api/v1/session first, or send a developer token as Authorization: Bearer"

# Refusals of an endpoint: for operators or anyone who looks, for operators' and anyone's changes.
LOOKING_REFUSALS = (SessionExpired, RoleMissing, PasswordChangeNeeded, TooManyTries)
READER_REFUSALS = (*LOOKING_REFUSALS, TokenInvalid, ScopeMissing)
OPERATOR_REFUSALS = (*LOOKING_REFUSALS, CsrfMissing, IdempotencyMismatch)
DRIVER_REFUSALS = (*READER_REFUSALS, CsrfMissing, IdempotencyMismatch)
SECOND_FACTOR_REFUSALS = (SecondFactorNeeded, SecondFactorMissing)

_cookie = APIKeyCookie(
    name=SESSION_COOKIE,
    scheme_name="OperatorSession",
    description="Set by POST /api/v1/session; HttpOnly, SameSite=Strict. The roles named are the operator's: "
    "one of them is needed.",
    auto_error=False,
)
_csrf = APIKeyHeader(
    name=CSRF_HEADER,
    scheme_name="CsrfToken",
    description="The csrf_token that POST and GET /api/v1/session answer; needed for every change.",
    auto_error=False,
)
_bearer = HTTPBearer(
    scheme_name="DeveloperToken",
    description="A developer token from POST /api/v1/developer-tokens; the roles named are its scopes.",
    auto_error=False,
)


@dataclass(frozen=True, slots=True)
class Actor:
    """An operator or a developer's program.

    account  the same operator or token in every request; name is for the record
    """

    kind: Literal["operator", "developer"]
    account: str
    name: str


@dataclass(frozen=True, slots=True)
class OperatorContext:
    token: str
    operator: Operator
    session: OperatorSession

    @property
    def name(self) -> str:
        return self.operator.name

    @property
    def actor(self) -> Actor:
        return Actor("operator", f"operator:{self.operator.operator_id}", self.name)


def developer_actor(token: DeveloperToken) -> Actor:
    return Actor("developer", f"developer:{token.token_id}", f"developer:{token.name}")


async def signed_in(services: Services, token: str | None) -> OperatorContext:
    """Raises SessionExpired for a session that is over, unknown or missing."""
    if not token:
        raise SessionExpired(SIGNED_OUT)
    operator, session = await services.transactions.read(lambda uow: identity.operator_of(uow, token))
    return OperatorContext(token, operator, session)


async def looking_operator(services: Services, token: str | None) -> OperatorContext:
    """The caller that watches the live scene. Raises SessionExpired, PasswordChangeNeeded, RoleMissing."""
    operator = await signed_in(services, token)
    _require_role(operator, LOOK)
    return operator


async def _own_session(
    services: InjectedServices, token: Annotated[str | None, Depends(_cookie)]
) -> OperatorContext:
    return await signed_in(services, token)


async def _changing_own_session(
    operator: Annotated[OperatorContext, Depends(_own_session)],
    csrf_token: Annotated[str | None, Depends(_csrf)],
) -> OperatorContext:
    # A cookie alone may have been sent by another site's page; it cannot read the token.
    expected = identity.csrf_token_of(operator.token).encode()
    if not hmac.compare_digest((csrf_token or "").encode(), expected):
        raise CsrfMissing(f"send the session's csrf_token in the header {CSRF_HEADER}")
    return operator


SessionCookie = Annotated[str | None, Depends(_cookie)]
Credentials = HTTPAuthorizationCredentials | None
ActorDependency = Callable[..., Awaitable[Actor]]


def looking(permission: Permission) -> ActorDependency:
    """The dependency of an endpoint that only shows."""
    roles, scope = list(permission.roles), permission.scope
    if scope is None:

        async def operator(
            request: Request,
            services: InjectedServices,
            session: str | None = Security(_cookie, scopes=roles),
        ) -> Actor:
            return await _permitted(request, services, permission, await signed_in(services, session))

        return operator

    async def anyone(
        request: Request,
        services: InjectedServices,
        session: str | None = Security(_cookie, scopes=roles),
        bearer: Credentials = Security(_bearer, scopes=[scope]),
    ) -> Actor:
        if bearer is not None:
            return await _developer(services, bearer, scope)
        return await _permitted(request, services, permission, await signed_in(services, session))

    return anyone


def changing(permission: Permission) -> ActorDependency:
    """The dependency of an endpoint that changes something."""
    roles, scope = list(permission.roles), permission.scope
    if scope is None:

        async def operator(
            request: Request,
            services: InjectedServices,
            session: str | None = Security(_cookie, scopes=roles),
            csrf_token: str | None = Depends(_csrf),
        ) -> Actor:
            changing = await _changing_own_session(await signed_in(services, session), csrf_token)
            return await _permitted(request, services, permission, changing)

        return operator

    async def anyone(
        request: Request,
        services: InjectedServices,
        session: str | None = Security(_cookie, scopes=roles),
        csrf_token: str | None = Depends(_csrf),
        bearer: Credentials = Security(_bearer, scopes=[scope]),
    ) -> Actor:
        # A browser sends no bearer token by itself, so a change with one needs no CSRF token.
        if bearer is not None:
            return await _developer(services, bearer, scope)
        changing = await _changing_own_session(await signed_in(services, session), csrf_token)
        return await _permitted(request, services, permission, changing)

    return anyone


async def _permitted(
    request: Request, services: Services, permission: Permission, operator: OperatorContext
) -> Actor:
    """Raises RoleMissing, PasswordChangeNeeded, SecondFactorNeeded, SecondFactorMissing.

    A refusal is entered in the audit log: it may be the first sign of a stolen session.
    """
    try:
        _require_role(operator, permission)
        if permission.second_factor:
            await require_second_factor(services, operator)
    except (RoleMissing, SecondFactorNeeded, SecondFactorMissing) as error:
        services.limits.commands.take(operator.actor.account, now_ns(services))
        await _record_refusal(request, services, operator.actor, error)
        raise
    return operator.actor


def _require_role(operator: OperatorContext, permission: Permission) -> None:
    if operator.operator.initial_until is not None:
        raise PasswordChangeNeeded("choose your own password first: POST /session/password")
    if not operator.operator.roles & set(permission.roles):
        needed = " or ".join(permission.roles)
        raise RoleMissing(f"this needs the role {needed}; an admin can give it to you")


async def require_second_factor(services: Services, operator: OperatorContext) -> None:
    """Of an operator who has one, or where the settings ask for one.

    Raises SecondFactorNeeded, SecondFactorMissing.
    """
    operator_id = operator.operator.operator_id
    factor = await services.transactions.read(lambda uow: uow.second_factors.confirmed(operator_id))
    if factor is None:
        if services.settings.second_factor_required:
            raise SecondFactorMissing("set up a second factor first: POST /session/second-factor")
        return
    lifetime_s = services.settings.second_factor_hours * 3600.0
    if not factor.holds(operator.session.checked_at, services.clock.now(), lifetime_s):
        raise SecondFactorNeeded(
            "give a code of your authenticator first: POST /session/second-factor/checks"
        )


async def _record_refusal(request: Request, services: Services, actor: Actor, error: DomainError) -> None:
    action = AuditAction(operation_of(request), subject_of(request), target_of(request), outcome=error.code)
    caller = Caller(actor.kind, actor.name, address_of(request))
    await services.transactions.run(lambda uow: audit.append(uow, caller, action))


async def _metrics_reader(
    request: Request,
    services: InjectedServices,
    session: str | None = Security(_cookie, scopes=list(LOOK.roles)),
    bearer: Credentials = Security(_bearer, scopes=["read"]),
) -> None:
    """Prometheus, by the token of the settings, or any reader."""
    expected = services.settings.metrics_token
    if (
        expected
        and bearer is not None
        and hmac.compare_digest(bearer.credentials.encode(), expected.encode())
    ):
        return
    if bearer is not None:
        await _developer(services, bearer, "read")
        return
    await _permitted(request, services, LOOK, await signed_in(services, session))


async def _optional_developer(
    services: InjectedServices, bearer: Annotated[Credentials, Security(_bearer, scopes=["drive"])]
) -> Actor | None:
    return None if bearer is None else await _developer(services, bearer, "drive")


async def _developer(services: Services, bearer: HTTPAuthorizationCredentials, scope: Scope) -> Actor:
    """Raises TokenInvalid, ScopeMissing."""
    secret = bearer.credentials
    token = await services.transactions.read(lambda uow: identity.developer_of(uow, secret, scope))
    return developer_actor(token)


Reader = Annotated[Actor, Depends(looking(LOOK))]
MetricsReader = Annotated[None, Depends(_metrics_reader)]
OptionalDeveloper = Annotated[Actor | None, Depends(_optional_developer)]
# An operator's own session: open to every role, and while an initial password is not changed yet.
OwnSession = Annotated[OperatorContext, Depends(_own_session)]
ChangingOwnSession = Annotated[OperatorContext, Depends(_changing_own_session)]


async def _client(request: Request) -> str:
    """Whose budget a request of this client takes from."""
    return budget_of(request.client.host) if request.client else "unknown"


Client = Annotated[str, Depends(_client)]


def now_ns(services: Services) -> int:
    return ns_of(services.clock.now())
