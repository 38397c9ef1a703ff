"""Authentication of operators by cookie and CSRF token; addresses of clients."""

import hmac
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Request
from fastapi.security import APIKeyCookie, APIKeyHeader

from server.api.problems import CsrfMissing
from server.api.services import InjectedServices, Services
from server.domain.errors import SessionExpired
from server.domain.instants import ns_of
from server.domain.record.identity import Operator, OperatorSession
from server.usecases.record import identity

SESSION_COOKIE = "campusloop_session"
CSRF_HEADER = "X-CSRF-Token"

SIGNED_OUT = "sign in at POST /api/v1/session first"

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


@dataclass(frozen=True, slots=True)
class OperatorContext:
    token: str
    operator: Operator
    session: OperatorSession

    @property
    def name(self) -> str:
        return self.operator.name


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
    expected = operator.session.csrf_token.encode()
    if not hmac.compare_digest((csrf_token or "").encode(), expected):
        raise CsrfMissing(f"send the session's csrf_token in the header {CSRF_HEADER}")
    return operator


ReadingOperator = Annotated[OperatorContext, Depends(_reading)]
ChangingOperator = Annotated[OperatorContext, Depends(_changing)]


async def _client(request: Request) -> str:
    return request.client.host if request.client else "unknown"


Client = Annotated[str, Depends(_client)]


def now_ns(services: Services) -> int:
    return ns_of(services.clock.now())
