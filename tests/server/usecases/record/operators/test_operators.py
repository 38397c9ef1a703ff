"""Operators by name: who may be what, and who may come in."""

import pytest

from server.domain.errors import LastAdmin, NameTaken, OperatorUnknown, SessionExpired, WrongCredentials
from server.domain.record.identity import ALL_ROLES, Operator, Role
from server.usecases.record import identity
from server.usecases.record.operators import operators
from tests.server.usecases.campus_under_test import CampusUnderTest


def make(campus: CampusUnderTest, name: str, *roles: Role) -> Operator:
    return campus.do(lambda uow: operators.create(uow, name, roles, f"plain:{name}", "root"))


def change(campus: CampusUnderTest, name: str, *roles: Role, disabled: bool = False) -> Operator:
    return campus.do(lambda uow: operators.change(uow, name, roles, disabled=disabled, by="root"))


def test_the_operator_of_the_settings_has_all_roles(campus: CampusUnderTest) -> None:
    made = campus.do(lambda uow: identity.set_password(uow, "ann", "right"))
    assert made.roles == ALL_ROLES


def test_a_name_belongs_to_one_operator(campus: CampusUnderTest) -> None:
    make(campus, "ann")
    with pytest.raises(NameTaken, match="ann"):
        make(campus, "ann", "admin")


def test_every_operator_may_look(campus: CampusUnderTest) -> None:
    assert make(campus, "ann").roles == {"viewer"}
    assert change(campus, "ann", "safety").roles == {"viewer", "safety"}


def test_an_initial_password_is_over_after_its_time(campus: CampusUnderTest) -> None:
    make(campus, "ann", "dispatcher")
    campus.sign_in("ann", "ann")
    campus.clock.advance(campus.rules.initial_password_s)
    with pytest.raises(WrongCredentials):
        campus.sign_in("ann", "ann")


def test_ones_own_password_has_no_end_and_ends_the_other_sessions(campus: CampusUnderTest) -> None:
    ann = make(campus, "ann")
    here, there = campus.sign_in("ann", "ann"), campus.sign_in("ann", "ann")
    session = here.session.token_sha256
    campus.do(lambda uow: operators.choose_password(uow, ann, session, "plain:my own"))
    campus.read(lambda uow: identity.operator_of(uow, here.token))
    with pytest.raises(SessionExpired):
        campus.read(lambda uow: identity.operator_of(uow, there.token))
    campus.clock.advance(campus.rules.initial_password_s)
    campus.sign_in("ann", "my own")


def test_a_disabled_operator_is_out_and_stays_out_until_enabled(campus: CampusUnderTest) -> None:
    make(campus, "ann", "safety")
    opened = campus.sign_in("ann", "ann")
    change(campus, "ann", "safety", disabled=True)
    with pytest.raises(SessionExpired):
        campus.read(lambda uow: identity.operator_of(uow, opened.token))
    with pytest.raises(WrongCredentials):
        campus.sign_in("ann", "ann")
    change(campus, "ann", "safety")
    campus.sign_in("ann", "ann")


def test_the_last_admin_cannot_be_disabled_or_lose_the_role(campus: CampusUnderTest) -> None:
    make(campus, "ann", "admin")
    make(campus, "bob", "admin")
    change(campus, "bob", "safety")
    with pytest.raises(LastAdmin):
        change(campus, "ann", "admin", disabled=True)
    with pytest.raises(LastAdmin):
        change(campus, "ann", "safety")
    change(campus, "bob", "admin")
    change(campus, "ann", "safety")


def test_a_reset_password_ends_the_sessions_and_must_be_changed(campus: CampusUnderTest) -> None:
    make(campus, "ann")
    opened = campus.sign_in("ann", "ann")
    again = campus.do(lambda uow: operators.reset_password(uow, "ann", "plain:new", "root"))
    assert again.initial_until is not None
    with pytest.raises(SessionExpired):
        campus.read(lambda uow: identity.operator_of(uow, opened.token))


def test_a_name_that_nobody_has_is_told(campus: CampusUnderTest) -> None:
    with pytest.raises(OperatorUnknown):
        change(campus, "eve")
