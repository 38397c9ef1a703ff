"""Operators signing in and out."""

from datetime import datetime

from fastapi import APIRouter, Response
from pydantic import BaseModel, ConfigDict, Field

from server.api.access import SESSION_COOKIE, ChangingOperator, Client, ReadingOperator, now_ns
from server.api.problems import CsrfMissing, problems
from server.api.rate_limit import TooManyTries
from server.api.services import Given, Services
from server.domain.errors import SessionExpired, WrongCredentials
from server.domain.identity import Operator, OperatorSession
from server.usecases import identity

router = APIRouter(prefix="/session", tags=["session"])


class Credentials(BaseModel):
    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"example": {"name": "operator", "password": "correct horse battery"}},
    )

    name: str = Field(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f]+$")
    password: str = Field(min_length=1, max_length=256)


class SessionView(BaseModel):
    """Who is signed in. Send csrf_token in the header X-CSRF-Token with every change."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "name": "operator",
                "csrf_token": "3HqkW9dYx0m2u7aT",
                "expires_at": "2026-09-01T20:14:31Z",
            }
        }
    )

    name: str
    csrf_token: str
    expires_at: datetime


@router.post("", operation_id="sign_in", responses=problems(WrongCredentials, TooManyTries))
async def sign_in(
    credentials: Credentials, response: Response, services: Given, client: Client
) -> SessionView:
    """Sets the session cookie (HttpOnly, SameSite=Strict)."""
    services.limits.logins.take(client, now_ns(services))
    opened = await services.transactions.run(
        lambda uow: identity.login(uow, credentials.name, credentials.password)
    )
    lifetime = opened.session.expires_at - opened.session.opened_at
    response.set_cookie(
        SESSION_COOKIE,
        opened.token,
        max_age=int(lifetime.total_seconds()),
        path="/",
        secure=_is_secure(services),
        httponly=True,
        samesite="strict",
    )
    return _view(opened.operator, opened.session)


@router.get("", operation_id="get_session", responses=problems(SessionExpired))
async def get_session(operator: ReadingOperator) -> SessionView:
    """Who I am, and the CSRF token after a reload of the page."""
    return _view(operator.operator, operator.session)


@router.delete("", operation_id="sign_out", status_code=204, responses=problems(SessionExpired, CsrfMissing))
async def sign_out(response: Response, services: Given, operator: ChangingOperator) -> None:
    await services.transactions.run(lambda uow: identity.logout(uow, operator.token))
    response.delete_cookie(
        SESSION_COOKIE, path="/", secure=_is_secure(services), httponly=True, samesite="strict"
    )


def _is_secure(services: Services) -> bool:
    return services.settings.origin().startswith("https://")


def _view(operator: Operator, session: OperatorSession) -> SessionView:
    return SessionView(
        name=operator.name,
        csrf_token=session.csrf_token,
        expires_at=session.expires_at,
    )
