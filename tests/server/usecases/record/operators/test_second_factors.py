"""Second factors: which codes open, how often, and what the database knows of them."""

from dataclasses import dataclass

import pyotp
import pytest

from server.domain.errors import SecondFactorLocked, SecondFactorMissing, TicketKeyMissing
from server.domain.record.second_factors import WRONG_CODES_MAX
from server.domain.rides.ticket_keys import TicketKeys
from server.usecases.record import identity
from server.usecases.record.identity import CreatedSession
from server.usecases.record.operators import second_factors
from tests.server.usecases.campus_under_test import CampusUnderTest


@dataclass
class Ann:
    """An operator with an authenticator."""

    campus: CampusUnderTest
    session: CreatedSession
    totp: pyotp.TOTP
    recovery_codes: tuple[str, ...] = ()

    @property
    def code(self) -> str:
        return self.totp.at(self.campus.clock.now())

    def check(self, code: str) -> bool:
        operator, session = self.session.operator, self.session.session
        return self.campus.do(lambda uow: second_factors.check(uow, operator, session, code))


@pytest.fixture
def ann(campus: CampusUnderTest) -> Ann:
    campus.do(lambda uow: identity.set_password(uow, "ann", "right"))
    opened = campus.sign_in("ann", "right")
    made = campus.do(lambda uow: second_factors.begin(uow, opened.operator))
    one = Ann(campus, opened, pyotp.TOTP(made.secret))
    codes = campus.do(lambda uow: second_factors.confirm(uow, opened.operator, opened.session, one.code))
    assert codes is not None
    one.recovery_codes = codes
    campus.clock.advance(30.0)
    return one


def test_a_code_works_once(ann: Ann) -> None:
    code = ann.code
    assert ann.check(code)
    assert not ann.check(code)
    ann.campus.clock.advance(30.0)
    assert ann.check(ann.code)


def test_the_code_that_confirmed_is_used_up(campus: CampusUnderTest) -> None:
    campus.do(lambda uow: identity.set_password(uow, "bob", "right"))
    opened = campus.sign_in("bob", "right")
    made = campus.do(lambda uow: second_factors.begin(uow, opened.operator))
    code = pyotp.TOTP(made.secret).at(campus.clock.now())
    campus.do(lambda uow: second_factors.confirm(uow, opened.operator, opened.session, code))
    assert not campus.do(lambda uow: second_factors.check(uow, opened.operator, opened.session, code))


def test_an_older_code_does_not_work_after_a_newer_one(ann: Ann) -> None:
    older = ann.code
    ann.campus.clock.advance(30.0)
    assert ann.check(ann.code)
    assert not ann.check(older)


def test_a_code_of_two_steps_ago_is_over(ann: Ann) -> None:
    code = ann.code
    ann.campus.clock.advance(60.0)
    assert not ann.check(code)


def test_a_recovery_code_works_once_and_marks_the_session(ann: Ann) -> None:
    assert ann.check(ann.recovery_codes[0])
    assert not ann.check(ann.recovery_codes[0])
    assert ann.check(ann.recovery_codes[1])


def test_wrong_codes_in_a_row_lock_the_factor_for_all_but_a_recovery_code(ann: Ann) -> None:
    wrong = f"{(int(ann.code) + 1) % 1_000_000:06d}"
    for _ in range(WRONG_CODES_MAX):
        assert not ann.check("0" * 6 if ann.code != "0" * 6 else wrong)
    with pytest.raises(SecondFactorLocked):
        ann.check(ann.code)
    assert ann.check(ann.recovery_codes[0])
    assert ann.check(ann.code)


def test_without_a_second_factor_there_is_nothing_to_check(campus: CampusUnderTest) -> None:
    campus.do(lambda uow: identity.set_password(uow, "bob", "right"))
    opened = campus.sign_in("bob", "right")
    with pytest.raises(SecondFactorMissing):
        campus.do(lambda uow: second_factors.check(uow, opened.operator, opened.session, "123456"))


def test_a_factor_that_was_begun_and_not_confirmed_counts_for_nothing(ann: Ann) -> None:
    operator = ann.session.operator
    begun = ann.campus.do(lambda uow: second_factors.begin(uow, operator))
    assert not ann.check(pyotp.TOTP(begun.secret).at(ann.campus.clock.now()))
    assert ann.check(ann.code)


def test_the_database_holds_neither_the_secret_nor_a_recovery_code(ann: Ann) -> None:
    with ann.campus.engine.connect() as connection:
        rows = str(connection.exec_driver_sql("SELECT * FROM second_factors").all())
    for secret in (ann.totp.secret, *ann.recovery_codes):
        assert secret not in rows


def test_other_ticket_keys_make_other_secrets() -> None:
    one, other = TicketKeys([b"a" * 32]), TicketKeys([b"b" * 32])
    secret = one.second_factor_secret(one.newest_id, "factor-1")
    assert len(secret) == 20
    assert secret != other.second_factor_secret(other.newest_id, "factor-1")
    assert secret != one.second_factor_secret(one.newest_id, "factor-2")
    with pytest.raises(TicketKeyMissing):
        other.second_factor_secret(one.newest_id, "factor-1")


def test_a_new_password_of_the_settings_takes_the_second_factor_away(ann: Ann) -> None:
    ann.campus.do(lambda uow: identity.set_password(uow, "ann", "another"))
    assert ann.campus.read(lambda uow: uow.second_factors.owners()) == frozenset()
