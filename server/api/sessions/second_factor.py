"""The second factor of the operator who is signed in."""

import io

import segno
from fastapi import APIRouter, Request

from server.api.problems import CsrfMissing, problems
from server.api.security.access import ChangingOwnSession, OperatorContext, now_ns, require_second_factor
from server.api.security.rate_limit import TooManyTries
from server.api.security.request_origin import address_of, operation_of
from server.api.services import InjectedServices, Services
from server.api.sessions.routes import own_password, session_view
from server.api.sessions.schemas import Code, NewSecondFactorView, Password, RecoveryCodes, SessionView
from server.domain.errors import (
    SecondFactorLocked,
    SecondFactorMissing,
    SecondFactorNeeded,
    SessionExpired,
    TicketKeyMissing,
    WrongCode,
    WrongCredentials,
)
from server.domain.record.audit import AuditAction, Caller
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import audit
from server.usecases.record.operators import second_factors

router = APIRouter(prefix="/session/second-factor", tags=["session"])

_OWN = (SessionExpired, CsrfMissing, TooManyTries)
_CODE = (*_OWN, WrongCode, SecondFactorMissing, SecondFactorLocked, TicketKeyMissing)
QR_SCALE = 5


@router.post(
    "",
    operation_id="begin_second_factor",
    status_code=201,
    responses=problems(*_OWN, WrongCredentials, SecondFactorNeeded, TicketKeyMissing),
)
async def begin_second_factor(
    body: Password, request: Request, services: InjectedServices, operator: ChangingOwnSession
) -> NewSecondFactorView:
    """Read it with an authenticator app, and confirm it with a code. One of before counts until then."""
    await own_password(services, operator, body.password)
    await _require_present_one(services, operator)

    def work(uow: UnitOfWork) -> second_factors.NewSecondFactor:
        _enter(uow, request, operator)
        return second_factors.begin(uow, operator.operator)

    made = await services.transactions.run(work)
    return NewSecondFactorView(secret=made.secret, uri=made.uri, qr_svg=_qr_svg(made.uri))


@router.post("/confirmation", operation_id="confirm_second_factor", responses=problems(*_CODE))
async def confirm_second_factor(
    body: Code, request: Request, services: InjectedServices, operator: ChangingOwnSession
) -> RecoveryCodes:
    """The first code of the authenticator: from now on the second factor counts."""
    _take_try(services, operator)

    def work(uow: UnitOfWork) -> tuple[str, ...] | None:
        codes = second_factors.confirm(uow, operator.operator, operator.session, body.code)
        _enter(uow, request, operator, "done" if codes else WrongCode.code)
        return codes

    codes = await services.transactions.run(work)
    if codes is None:
        raise second_factors.wrong_code()
    return RecoveryCodes(recovery_codes=list(codes))


@router.post("/checks", operation_id="check_second_factor", responses=problems(*_CODE))
async def check_second_factor(
    body: Code, request: Request, services: InjectedServices, operator: ChangingOwnSession
) -> SessionView:
    """After it, this session may set vehicles in motion for a time. Stopping never asks for it."""
    _take_try(services, operator)

    def work(uow: UnitOfWork) -> bool:
        passed = second_factors.check(uow, operator.operator, operator.session, body.code)
        _enter(uow, request, operator, "done" if passed else WrongCode.code)
        return passed

    if not await services.transactions.run(work):
        raise second_factors.wrong_code()
    return await session_view(services, operator)


@router.delete(
    "",
    operation_id="remove_second_factor",
    status_code=204,
    responses=problems(*_OWN, SecondFactorNeeded),
)
async def remove_second_factor(
    request: Request, services: InjectedServices, operator: ChangingOwnSession
) -> None:
    """Only in a session in which it was checked lately."""
    await _require_present_one(services, operator)

    def work(uow: UnitOfWork) -> None:
        second_factors.remove(uow, operator.operator, operator.name)
        _enter(uow, request, operator)

    await services.transactions.run(work)


async def _require_present_one(services: Services, operator: OperatorContext) -> None:
    """An operator who has none yet may begin one, also where the settings ask for one."""
    try:
        await require_second_factor(services, operator)
    except SecondFactorMissing:
        return


def _take_try(services: Services, operator: OperatorContext) -> None:
    services.limits.second_factors.take(operator.actor.account, now_ns(services))


def _enter(uow: UnitOfWork, request: Request, operator: OperatorContext, outcome: str = "done") -> None:
    caller = Caller("operator", operator.name, address_of(request))
    audit.append(uow, caller, AuditAction(operation_of(request), outcome=outcome))


def _qr_svg(uri: str) -> str:
    picture = io.BytesIO()
    segno.make(uri, error="m", micro=False).save(picture, kind="svg", scale=QR_SCALE, xmldecl=False)
    return picture.getvalue().decode()
