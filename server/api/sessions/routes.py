"""Operators signing in and out."""

from datetime import timedelta
from typing import Annotated

from fastapi import APIRouter, Cookie, Response

from server.api.problems import CsrfMissing, problems
from server.api.security.access import SESSION_COOKIE, ChangingOperator, Client, ReadingOperator, now_ns
from server.api.security.rate_limit import TooManyTries
from server.api.services import InjectedServices, Services
from server.api.sessions.schemas import Credentials, SessionView
from server.domain.errors import SessionExpired, WrongCredentials
from server.domain.record.identity import Operator, OperatorSession
from server.usecases.record import identity

BROWSER_COOKIE = "campusloop_browser"
BROWSER_PATH = "/api/v1/session"
KNOWN_BROWSER = timedelta(days=180)

router = APIRouter(prefix="/session", tags=["session"])


@router.post("", operation_id="sign_in", responses=problems(WrongCredentials, TooManyTries))
async def sign_in(
    credentials: Credentials,
    response: Response,
    services: InjectedServices,
    client: Client,
    browser: Annotated[
        str | None, Cookie(alias=BROWSER_COOKIE, max_length=256, include_in_schema=False)
    ] = None,
) -> SessionView:
    """Sets the session cookie (HttpOnly, SameSite=Strict), and one by which this browser is known again."""
    name = credentials.name
    check = await services.transactions.read(lambda uow: identity.password_check(uow, name, browser or ""))
    _take_try(services, client, name, check.browser)
    async with services.limits.password_checks:
        operator = await services.offload.run(lambda: check.passed(credentials.password))
    opened = await services.transactions.run(lambda uow: identity.open_operator_session(uow, operator))
    lifetime = opened.session.expires_at - opened.session.opened_at
    _set_cookie(response, services, SESSION_COOKIE, opened.token, "/", lifetime)
    _set_cookie(response, services, BROWSER_COOKIE, opened.browser_token, BROWSER_PATH, KNOWN_BROWSER)
    return _view(opened.operator, opened.token, opened.session)


@router.get("", operation_id="get_session", responses=problems(SessionExpired))
async def get_session(operator: ReadingOperator) -> SessionView:
    """The signed-in operator, and the CSRF token after a reload of the page."""
    return _view(operator.operator, operator.token, operator.session)


@router.delete("", operation_id="sign_out", status_code=204, responses=problems(SessionExpired, CsrfMissing))
async def sign_out(response: Response, services: InjectedServices, operator: ChangingOperator) -> None:
    await services.transactions.run(lambda uow: identity.logout(uow, operator.token))
    response.delete_cookie(
        SESSION_COOKIE, path="/", secure=_is_secure(services), httponly=True, samesite="strict"
    )


def _take_try(services: Services, client: str, name: str, browser: str) -> None:
    """Raises TooManyTries.

    A browser in which this operator has signed in has tries of its own: nobody else can use them up, neither
    from the same network nor by guessing at this account from everywhere.
    """
    limits, now = services.limits, now_ns(services)
    if browser:
        limits.known_logins.take(browser, now)
        return
    limits.logins.take(client, now)
    limits.account_logins.take(name, now)


def _set_cookie(
    response: Response, services: Services, name: str, value: str, path: str, lifetime: timedelta
) -> None:
    response.set_cookie(
        name,
        value,
        max_age=int(lifetime.total_seconds()),
        path=path,
        secure=_is_secure(services),
        httponly=True,
        samesite="strict",
    )


def _is_secure(services: Services) -> bool:
    return services.settings.origin().startswith("https://")


def _view(operator: Operator, token: str, session: OperatorSession) -> SessionView:
    return SessionView(
        name=operator.name,
        csrf_token=identity.csrf_token_of(token),
        expires_at=session.expires_at,
    )
