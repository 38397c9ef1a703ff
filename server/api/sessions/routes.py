"""Operators signing in and out."""

from datetime import timedelta
from typing import Annotated

from fastapi import APIRouter, Cookie, Request, Response

from server.api.problems import CsrfMissing, problems
from server.api.security.access import (
    SESSION_COOKIE,
    ChangingOwnSession,
    Client,
    OperatorContext,
    OwnSession,
    now_ns,
)
from server.api.security.rate_limit import TooManyTries
from server.api.security.request_origin import address_of
from server.api.services import InjectedServices, Services
from server.api.sessions.schemas import Credentials, NewPassword, SessionView
from server.domain.errors import PasswordInSettings, SessionExpired, WrongCredentials
from server.domain.record.audit import AuditAction, Caller
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import audit, identity
from server.usecases.record.identity import CreatedSession, PasswordCheck
from server.usecases.record.operators import operators

BROWSER_COOKIE = "campusloop_browser"
BROWSER_PATH = "/api/v1/session"
KNOWN_BROWSER = timedelta(days=180)

router = APIRouter(prefix="/session", tags=["session"])


@router.post("", operation_id="sign_in", responses=problems(WrongCredentials, TooManyTries))
async def sign_in(
    credentials: Credentials,
    request: Request,
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
    opened = await _open(services, check, credentials.password, address_of(request))
    lifetime = opened.session.expires_at - opened.session.opened_at
    _set_cookie(response, services, SESSION_COOKIE, opened.token, "/", lifetime)
    _set_cookie(response, services, BROWSER_COOKIE, opened.browser_token, BROWSER_PATH, KNOWN_BROWSER)
    return await session_view(services, OperatorContext(opened.token, opened.operator, opened.session))


@router.get("", operation_id="get_session", responses=problems(SessionExpired))
async def get_session(services: InjectedServices, operator: OwnSession) -> SessionView:
    """The signed-in operator, and the CSRF token after a reload of the page."""
    return await session_view(services, operator)


@router.delete("", operation_id="sign_out", status_code=204, responses=problems(SessionExpired, CsrfMissing))
async def sign_out(
    request: Request, response: Response, services: InjectedServices, operator: ChangingOwnSession
) -> None:
    caller = Caller("operator", operator.name, address_of(request))

    def work(uow: UnitOfWork) -> None:
        identity.logout(uow, operator.token)
        audit.append(uow, caller, AuditAction("sign_out"))

    await services.transactions.run(work)
    response.delete_cookie(
        SESSION_COOKIE, path="/", secure=_is_secure(services), httponly=True, samesite="strict"
    )


@router.post(
    "/password",
    operation_id="choose_password",
    responses=problems(SessionExpired, CsrfMissing, WrongCredentials, PasswordInSettings, TooManyTries),
)
async def choose_password(
    body: NewPassword, request: Request, services: InjectedServices, operator: ChangingOwnSession
) -> SessionView:
    """A password of one's own. Every other session of the operator ends."""
    settings = services.settings
    if settings.operator_password and operator.name == settings.operator_name:
        raise PasswordInSettings("this password is the server's setting operator_password; change it there")
    check = await own_password(services, operator, body.password)
    async with services.limits.password_checks:
        password_hash = await services.offload.run(lambda: check.hasher.hash(body.new_password))
    caller = Caller("operator", operator.name, address_of(request))

    def work(uow: UnitOfWork) -> None:
        session_sha256 = operator.session.token_sha256
        operators.choose_password(uow, operator.operator, session_sha256, password_hash)
        audit.append(uow, caller, AuditAction("choose_password"))

    await services.transactions.run(work)
    return await session_view(services, operator)


async def own_password(services: Services, operator: OperatorContext, password: str) -> PasswordCheck:
    """That the one at the browser knows the password. Raises WrongCredentials, TooManyTries."""
    services.limits.known_logins.take(operator.actor.account, now_ns(services))
    check = await services.transactions.read(lambda uow: identity.password_check(uow, operator.name))
    async with services.limits.password_checks:
        await services.offload.run(lambda: check.passed(password))
    return check


async def _open(services: Services, check: PasswordCheck, password: str, address: str) -> CreatedSession:
    """The session, or WrongCredentials; both are in the audit log."""
    try:
        async with services.limits.password_checks:
            operator = await services.offload.run(lambda: check.passed(password))
        caller = Caller("operator", operator.name, address)

        def work(uow: UnitOfWork) -> CreatedSession:
            audit.append(uow, caller, AuditAction("sign_in"))
            return identity.open_operator_session(uow, operator)

        return await services.transactions.run(work)
    except WrongCredentials as error:
        # A name without an account is not entered: people type their password there.
        known = check.operator
        stranger = Caller("unknown", "" if known is None else known.name, address)
        failed = AuditAction("sign_in", outcome=error.code)
        await services.transactions.run(lambda uow: audit.append(uow, stranger, failed))
        raise


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


async def session_view(services: Services, operator: OperatorContext) -> SessionView:
    def work(uow: UnitOfWork) -> SessionView:
        known, session = identity.operator_of(uow, operator.token)
        factor = uow.second_factors.confirmed(known.operator_id)
        lifetime_s = services.settings.second_factor_hours * 3600.0
        checked_until = None
        if factor is not None and factor.holds(session.checked_at, uow.now, lifetime_s):
            assert session.checked_at is not None
            checked_until = session.checked_at + timedelta(seconds=lifetime_s)
        return SessionView(
            name=known.name,
            roles=sorted(known.roles),
            csrf_token=identity.csrf_token_of(operator.token),
            expires_at=session.expires_at,
            password_change_needed=known.initial_until is not None,
            second_factor=factor is not None,
            second_factor_required=services.settings.second_factor_required,
            second_factor_until=checked_until,
        )

    return await services.transactions.read(work)
