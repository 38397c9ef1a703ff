"""Which role opens which endpoint, from the OpenAPI document's own words."""

from collections.abc import Iterator
from typing import Any

import pytest

from server.api.routers import PREFIX, bare_app
from server.domain.record.identity import ALL_ROLES, Role
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity
from server.usecases.record.operators import operators
from tests.server.api.security.test_access import ask
from tests.server.api.server_under_test import ServerUnderTest

Operation = tuple[str, str]


def roles_of(operation: dict[str, Any]) -> frozenset[Role]:
    """Any of them opens it; none: it is open to others than operators, or to every operator's own session."""
    return frozenset(
        role for scheme in operation["security"] for role in scheme.get("OperatorSession", ()) if role
    )


GUARDED: dict[Operation, frozenset[Role]] = {
    (method.upper(), path.removeprefix(PREFIX)): roles_of(operation)
    for path, methods in bare_app().openapi()["paths"].items()
    for method, operation in methods.items()
    if roles_of(operation)
}


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerUnderTest]:
    server = ServerUnderTest(tmp_path_factory.mktemp("var"), commands_per_minute=100_000)
    yield server
    server.close()


@pytest.fixture(scope="module")
def sessions(running: ServerUnderTest) -> dict[frozenset[Role], dict[str, str]]:
    """For each set of roles, what an operator with these roles sends."""
    return {roles: headers_of(running, roles) for roles in role_sets()}


def role_sets() -> set[frozenset[Role]]:
    """Each role alone, and all roles but those that open an endpoint."""
    alone = {frozenset({role}) for role in ALL_ROLES}
    return alone | {ALL_ROLES - roles for roles in GUARDED.values()}


def headers_of(server: ServerUnderTest, roles: frozenset[Role]) -> dict[str, str]:
    name = "-".join(sorted(roles)) or "none"

    def work(uow: UnitOfWork) -> str:
        made = operators.create(uow, name, roles, "plain:x", "operator")
        own = operators.choose_password(uow, made, "", "plain:own")
        return identity.open_operator_session(uow, own).token

    token = server.transact(work)
    cookie = f"campusloop_session={token}"
    return {"Cookie": cookie, "X-CSRF-Token": identity.csrf_token_of(token)}


def test_every_role_opens_something() -> None:
    assert frozenset().union(*GUARDED.values()) == ALL_ROLES
    assert len(GUARDED) >= 50


@pytest.mark.parametrize("operation", sorted(GUARDED), ids=" ".join)
def test_each_role_that_is_named_opens_it(
    running: ServerUnderTest, sessions: dict[frozenset[Role], dict[str, str]], operation: Operation
) -> None:
    for role in GUARDED[operation]:
        answer = ask(running, operation, headers=sessions[frozenset({role})])
        assert answer.status_code not in (401, 403), (role, answer.text)


@pytest.mark.parametrize(
    "operation", sorted(one for one, roles in GUARDED.items() if "viewer" not in roles), ids=" ".join
)
def test_all_other_roles_together_do_not_open_it(
    running: ServerUnderTest, sessions: dict[frozenset[Role], dict[str, str]], operation: Operation
) -> None:
    answer = ask(running, operation, headers=sessions[ALL_ROLES - GUARDED[operation]])
    assert (answer.status_code, answer.json()["code"]) == (403, "role_missing")
