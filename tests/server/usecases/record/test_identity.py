"""Who is let in, for how long, and what is kept of their secrets."""

from dataclasses import replace
from datetime import timedelta

import pytest

from server.domain.errors import ScopeMissing, SessionExpired, TokenInvalid, WrongCredentials
from server.domain.record.identity import Scope
from server.usecases.record import identity
from server.usecases.record.identity import CreatedSession, CreatedToken
from tests.server.usecases.campus_under_test import CampusUnderTest

SECOND = timedelta(seconds=1)


def login(campus: CampusUnderTest, password: str = "right", name: str = "ann") -> CreatedSession:
    return campus.sign_in(name, password)


def with_ann(campus: CampusUnderTest, password: str = "right") -> None:
    campus.do(lambda uow: identity.set_password(uow, "ann", password))


def a_token(campus: CampusUnderTest, *scopes: Scope, valid_s: float = 3600.0) -> CreatedToken:
    return campus.do(lambda uow: identity.create_developer_token(uow, "night", scopes, valid_s, "ann"))


def may(campus: CampusUnderTest, secret: str, scope: Scope) -> bool:
    try:
        campus.read(lambda uow: identity.developer_of(uow, secret, scope))
    except ScopeMissing:
        return False
    return True


def test_an_operator_is_let_in_with_the_password_only(campus: CampusUnderTest) -> None:
    with_ann(campus)
    with pytest.raises(WrongCredentials) as wrong:
        login(campus, "wrong")
    with pytest.raises(WrongCredentials) as unknown:
        login(campus, name="eve")
    assert wrong.value.detail == unknown.value.detail, "nobody learns which names there are"
    session = login(campus)
    operator, known = campus.read(lambda uow: identity.operator_of(uow, session.token))
    assert (operator.name, known) == ("ann", session.session)


def test_a_session_ends_at_its_time(campus: CampusUnderTest) -> None:
    with_ann(campus)
    session = login(campus)
    lasts = session.session.expires_at - campus.clock.now()
    assert lasts.total_seconds() == campus.rules.operator_session_s
    campus.clock.time = session.session.expires_at - SECOND
    campus.read(lambda uow: identity.operator_of(uow, session.token))
    campus.clock.time = session.session.expires_at
    with pytest.raises(SessionExpired):
        campus.read(lambda uow: identity.operator_of(uow, session.token))


def test_signing_out_ends_this_session_and_no_other(campus: CampusUnderTest) -> None:
    with_ann(campus)
    one, other = login(campus), login(campus)
    for _ in range(2):
        campus.do(lambda uow: identity.logout(uow, one.token))
    with pytest.raises(SessionExpired):
        campus.read(lambda uow: identity.operator_of(uow, one.token))
    campus.read(lambda uow: identity.operator_of(uow, other.token))


def test_a_new_password_replaces_the_old_one_of_the_same_operator(campus: CampusUnderTest) -> None:
    with_ann(campus)
    before = campus.read(lambda uow: uow.identity.operator_by_name("ann"))
    campus.clock.advance(60.0)
    with_ann(campus, "another")
    after = campus.read(lambda uow: uow.identity.operator_by_name("ann"))
    assert before is not None
    assert after is not None
    assert (after.operator_id, after.created_at) == (before.operator_id, before.created_at)
    with pytest.raises(WrongCredentials):
        login(campus)
    login(campus, "another")


def test_a_new_password_ends_the_sessions_of_this_operator_and_of_no_other(campus: CampusUnderTest) -> None:
    with_ann(campus)
    campus.do(lambda uow: identity.set_password(uow, "bob", "secret"))
    anns, bobs = login(campus), campus.sign_in("bob", "secret")
    with_ann(campus, "right")
    campus.read(lambda uow: identity.operator_of(uow, anns.token))
    with_ann(campus, "new")
    with pytest.raises(SessionExpired):
        campus.read(lambda uow: identity.operator_of(uow, anns.token))
    campus.read(lambda uow: identity.operator_of(uow, bobs.token))


def test_a_password_that_changed_while_it_was_compared_opens_no_session(campus: CampusUnderTest) -> None:
    with_ann(campus)
    check = campus.read(lambda uow: identity.password_check(uow, "ann"))
    operator = check.passed("right")
    with_ann(campus, "new")
    with pytest.raises(WrongCredentials):
        campus.do(lambda uow: identity.open_operator_session(uow, operator))


@pytest.mark.parametrize(
    ("scopes", "allowed"),
    [
        (("read",), ("read",)),
        (("read", "drive"), ("read", "drive")),
        (("infrastructure",), ("infrastructure",)),
    ],
)
def test_a_token_may_do_what_its_scopes_say_and_nothing_else(
    campus: CampusUnderTest, scopes: tuple[Scope, ...], allowed: tuple[Scope, ...]
) -> None:
    secret = a_token(campus, *scopes).secret
    every: tuple[Scope, ...] = ("read", "drive", "infrastructure")
    assert tuple(scope for scope in every if may(campus, secret, scope)) == allowed


def test_a_token_ends_at_its_time(campus: CampusUnderTest) -> None:
    made = a_token(campus, "read", valid_s=60.0)
    campus.clock.advance(59.0)
    assert may(campus, made.secret, "read")
    campus.clock.advance(1.0)
    with pytest.raises(TokenInvalid):
        may(campus, made.secret, "read")


def test_a_revoked_token_opens_nothing_and_stays_revoked_since_then(campus: CampusUnderTest) -> None:
    made, other = a_token(campus, "read"), a_token(campus, "read")
    revoked_at = campus.clock.now()
    for _ in range(2):
        gone = campus.do(lambda uow: identity.revoke_developer_token(uow, made.token.token_id, "ann"))
        assert gone.revoked_at == revoked_at
        campus.clock.advance(10.0)
    with pytest.raises(TokenInvalid):
        may(campus, made.secret, "read")
    assert may(campus, other.secret, "read")
    listed = campus.read(lambda uow: uow.identity.developer_tokens())
    assert {token.token_id for token in listed} == {made.token.token_id, other.token.token_id}


def test_a_secret_nobody_was_given_opens_nothing(campus: CampusUnderTest) -> None:
    made = a_token(campus, "read")
    for secret in ("", "guess", made.token.token_sha256):
        with pytest.raises(TokenInvalid):
            may(campus, secret, "read")
    with pytest.raises(TokenInvalid, match="token-99"):
        campus.do(lambda uow: identity.revoke_developer_token(uow, "token-99", "ann"))


def test_of_secrets_only_their_hashes_are_stored(campus: CampusUnderTest) -> None:
    with_ann(campus)
    session, token = login(campus), a_token(campus, "read")
    code = campus.enrol("shuttle-9")
    with campus.engine.connect() as connection:
        for table in ("operator_sessions", "developer_tokens", "enrolment_codes"):
            rows = str(connection.exec_driver_sql(f"SELECT * FROM {table}").all())
            for secret in (session.token, token.secret, code):
                assert secret not in rows, table


def test_a_code_enters_a_new_vehicle_and_brings_a_retired_one_back(campus: CampusUnderTest) -> None:
    campus.enrol("shuttle-9", seats=4, wheelchair_places=1)
    made = campus.read(lambda uow: uow.vehicles.get("shuttle-9"))
    assert made is not None
    assert (made.seats, made.wheelchair_places, made.retired) == (4, 1, False)
    campus.do(lambda uow: uow.vehicles.save(replace(made, retired=True)))
    campus.enrol("shuttle-9", seats=8, name="Nine again")
    back = campus.read(lambda uow: uow.vehicles.get("shuttle-9"))
    assert back is not None
    assert (back.name, back.retired, back.seats) == ("Nine again", False, 4)
