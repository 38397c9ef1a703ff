"""Authentication: operators by cookie and CSRF token, developers by bearer token; addresses of clients."""

import hmac
from dataclasses import dataclass
from typing import Annotated, Literal

from fastapi import Depends, Request, Security
from fastapi.security import APIKeyCookie, APIKeyHeader, HTTPAuthorizationCredentials, HTTPBearer

from server.addresses import budget_of
from server.api.problems import CsrfMissing
from server.api.security.rate_limit import TooManyTries
from server.api.services import InjectedServices, Services
from server.domain.errors import IdempotencyMismatch, ScopeMissing, SessionExpired, TokenInvalid
from server.domain.instants import ns_of
from server.domain.record.identity import DeveloperToken, Operator, OperatorSession, Scope
from server.usecases.record import identity

SESSION_COOKIE = "campusloop_session"
CSRF_HEADER = "X-CSRF-Token"

SIGNED_OUT = "sign in at POST /api/v1/session first, or send a developer token as Authorization: Bearer"

# Refusals of an endpoint: for readers, for an operator's changes, for anyone's changes.
READER_REFUSALS = (SessionExpired, TokenInvalid, ScopeMissing)
OPERATOR_REFUSALS = (SessionExpired, CsrfMissing, IdempotencyMismatch, TooManyTries)
DRIVER_REFUSALS = (*READER_REFUSALS, CsrfMissing, IdempotencyMismatch, TooManyTries)

_cookie = APIKeyCookie(
    name=SESSION_COOKIE,
    scheme_name="OperatorSession",
    description="Set by POST /api/v1/session; HttpOnly, SameSite=Strict.",
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


async def _reading(
    services: InjectedServices, token: Annotated[str | None, Depends(_cookie)]
) -> OperatorContext:
    return await signed_in(services, token)


async def _changing(
    operator: Annotated[OperatorContext, Depends(_reading)],
    csrf_token: Annotated[str | None, Depends(_csrf)],
) -> OperatorContext:
    # A cookie alone may have been sent by another site's page; it cannot read the token.
    expected = identity.csrf_token_of(operator.token).encode()
    if not hmac.compare_digest((csrf_token or "").encode(), expected):
        raise CsrfMissing(f"send the session's csrf_token in the header {CSRF_HEADER}")
    return operator


SessionCookie = Annotated[str | None, Depends(_cookie)]
Credentials = HTTPAuthorizationCredentials | None


async def _reader(
    services: InjectedServices,
    session: SessionCookie,
    bearer: Annotated[Credentials, Security(_bearer, scopes=["read"])],
) -> Actor:
    if bearer is not None:
        return await _developer(services, bearer, "read")
    return (await signed_in(services, session)).actor


async def _metrics_reader(
    services: InjectedServices,
    session: SessionCookie,
    bearer: Annotated[Credentials, Security(_bearer, scopes=["read"])],
) -> None:
    """Prometheus, by the token of the settings, or any reader."""
    expected = services.settings.metrics_token
    if (
        expected
        and bearer is not None
        and hmac.compare_digest(bearer.credentials.encode(), expected.encode())
    ):
        return
    await _reader(services, session, bearer)


async def _driver(
    services: InjectedServices,
    session: SessionCookie,
    csrf_token: Annotated[str | None, Depends(_csrf)],
    bearer: Annotated[Credentials, Security(_bearer, scopes=["drive"])],
) -> Actor:
    # A browser sends no bearer token by itself, so a change with one needs no CSRF token.
    if bearer is not None:
        return await _developer(services, bearer, "drive")
    return (await _changing(await signed_in(services, session), csrf_token)).actor


async def _optional_developer(
    services: InjectedServices, bearer: Annotated[Credentials, Security(_bearer, scopes=["drive"])]
) -> Actor | None:
    return None if bearer is None else await _developer(services, bearer, "drive")


async def _developer(services: Services, bearer: HTTPAuthorizationCredentials, scope: Scope) -> Actor:
    """Raises TokenInvalid, ScopeMissing."""
    secret = bearer.credentials
    token = await services.transactions.read(lambda uow: identity.developer_of(uow, secret, scope))
    return developer_actor(token)


Reader = Annotated[Actor, Depends(_reader)]
MetricsReader = Annotated[None, Depends(_metrics_reader)]
Driver = Annotated[Actor, Depends(_driver)]
OptionalDeveloper = Annotated[Actor | None, Depends(_optional_developer)]
ReadingOperator = Annotated[OperatorContext, Depends(_reading)]
ChangingOperator = Annotated[OperatorContext, Depends(_changing)]


async def _client(request: Request) -> str:
    """Whose budget a request of this client takes from."""
    return budget_of(request.client.host) if request.client else "unknown"


Client = Annotated[str, Depends(_client)]


def now_ns(services: Services) -> int:
    return ns_of(services.clock.now())
