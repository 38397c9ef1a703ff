"""Second factors: enrolling an authenticator, checking its codes, recovery codes."""

import base64
import hmac
from dataclasses import dataclass, replace

import pyotp

from server.domain.errors import SecondFactorLocked, SecondFactorMissing, WrongCode
from server.domain.record.identity import Operator, OperatorSession
from server.domain.record.second_factors import SecondFactor, steps_around
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.identity import sha256_of
from server.usecases.record.server_events import record_event

ISSUER = "Campusloop"
RECOVERY_CODES = 10


@dataclass(frozen=True, slots=True)
class NewSecondFactor:
    """What an authenticator app reads; shown once.

    secret  in base32, to type where no picture can be taken
    uri     otpauth://, to show as a QR code
    """

    secret: str
    uri: str


def begin(uow: UnitOfWork, operator: Operator) -> NewSecondFactor:
    """A second factor that counts as soon as a code of it is given. One that counts already goes on."""
    uow.second_factors.remove_begun(operator.operator_id)
    factor = SecondFactor(
        campus_id=uow.campus_id,
        factor_id=uow.ids.new_id("factor"),
        operator_id=operator.operator_id,
        ticket_key_id=uow.tickets.newest_id,
        made_at=uow.now,
    )
    uow.second_factors.save(factor)
    totp = _totp(uow, factor)
    return NewSecondFactor(
        totp.secret, totp.provisioning_uri(name=operator.name, issuer_name=f"{ISSUER} {uow.campus_id}")
    )


def confirm(
    uow: UnitOfWork, operator: Operator, session: OperatorSession, code: str
) -> tuple[str, ...] | None:
    """The recovery codes, shown once: the second factor counts from now on. None for a wrong code.

    Raises SecondFactorMissing if none was begun, SecondFactorLocked.
    """
    begun = uow.second_factors.begun(operator.operator_id)
    if begun is None:
        raise SecondFactorMissing("begin with POST /session/second-factor")
    step = _step_of(uow, _unlocked(begun), code)
    if step is None:
        uow.second_factors.save(replace(begun, wrong_codes=begun.wrong_codes + 1))
        return None
    codes = tuple(uow.ids.token() for _ in range(RECOVERY_CODES))
    uow.second_factors.remove_all(operator.operator_id)
    hashes = frozenset(sha256_of(one) for one in codes)
    uow.second_factors.save(
        replace(begun, confirmed_at=uow.now, last_step=step, wrong_codes=0, recovery_sha256=hashes)
    )
    uow.identity.mark_checked(session.token_sha256, uow.now)
    record_event(uow, "operator.second_factor_set", operator.operator_id, operator.name)
    return codes


def check(uow: UnitOfWork, operator: Operator, session: OperatorSession, code: str) -> bool:
    """Whether the code, or recovery code, is good; each works once. A wrong one is counted: commit it.

    Raises SecondFactorMissing, SecondFactorLocked.
    """
    factor = uow.second_factors.confirmed(operator.operator_id)
    if factor is None:
        raise SecondFactorMissing("you have no second factor; set one up first")
    if sha256_of(code) in factor.recovery_sha256:
        used = replace(factor, wrong_codes=0, recovery_sha256=factor.recovery_sha256 - {sha256_of(code)})
        record_event(uow, "operator.recovery_code_used", operator.operator_id, operator.name)
        return _passed(uow, used, session)
    step = _step_of(uow, _unlocked(factor), code)
    if step is None:
        uow.second_factors.save(replace(factor, wrong_codes=factor.wrong_codes + 1))
        return False
    return _passed(uow, replace(factor, wrong_codes=0, last_step=step), session)


def remove(uow: UnitOfWork, operator: Operator, by: str) -> None:
    """The operator has none afterwards."""
    uow.second_factors.remove_all(operator.operator_id)
    record_event(uow, "operator.second_factor_removed", operator.operator_id, by)


def wrong_code() -> WrongCode:
    return WrongCode("this code is wrong or was used already; wait for the next one of your authenticator")


def _passed(uow: UnitOfWork, factor: SecondFactor, session: OperatorSession) -> bool:
    uow.second_factors.save(factor)
    uow.identity.mark_checked(session.token_sha256, uow.now)
    return True


def _unlocked(factor: SecondFactor) -> SecondFactor:
    if factor.is_locked:
        raise SecondFactorLocked("too many wrong codes; use a recovery code, or ask another admin")
    return factor


def _step_of(uow: UnitOfWork, factor: SecondFactor, code: str) -> int | None:
    """The step whose code this is, if it may be used now."""
    totp = _totp(uow, factor)
    for step in steps_around(uow.now):
        fits = hmac.compare_digest(totp.generate_otp(step).encode(), code.encode())
        if fits and step > factor.last_step:
            return step
    return None


def _totp(uow: UnitOfWork, factor: SecondFactor) -> pyotp.TOTP:
    secret = uow.tickets.second_factor_secret(factor.ticket_key_id, factor.factor_id)
    return pyotp.TOTP(base64.b32encode(secret).decode())
