"""Developer tokens on REST: what each scope opens, endpoint by endpoint."""

from collections.abc import Iterator

import pytest

from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity
from tests.server.api.security.test_access import CHANGES, READING, ask
from tests.server.api.server_under_test import ServerUnderTest

# What stays with operators: session, secrets, who drives at all, calendars, incidents and notes about them,
# emergencies, erasure, and the map.
OPERATORS_ONLY = {
    ("GET", "/session"),
    ("DELETE", "/session"),
    ("POST", "/session/password"),
    ("POST", "/session/second-factor"),
    ("POST", "/session/second-factor/confirmation"),
    ("POST", "/session/second-factor/checks"),
    ("DELETE", "/session/second-factor"),
    ("GET", "/operators"),
    ("POST", "/operators"),
    ("PUT", "/operators/{name}"),
    ("POST", "/operators/{name}/password"),
    ("DELETE", "/operators/{name}/second-factor"),
    ("GET", "/audit"),
    ("GET", "/audit/verify"),
    ("GET", "/audit/{number}"),
    ("GET", "/developer-tokens"),
    ("POST", "/developer-tokens"),
    ("DELETE", "/developer-tokens/{token_id}"),
    ("POST", "/enrolments/codes"),
    ("DELETE", "/vehicles/{vehicle_id}"),
    ("DELETE", "/vehicles/{vehicle_id}/key"),
    ("PUT", "/vehicles/{vehicle_id}/place"),
    ("POST", "/vehicles/{vehicle_id}/position"),
    ("POST", "/vehicles/{vehicle_id}/evacuations"),
    ("POST", "/rides/id/{ride_id}/erase"),
    ("POST", "/series/id/{series_id}/erase"),
    ("PUT", "/vehicles/{vehicle_id}/shifts"),
    ("DELETE", "/vehicles/{vehicle_id}/shifts"),
    ("PUT", "/service/patterns/{service_id}"),
    ("PUT", "/service/trips"),
    ("POST", "/service/trips/previews"),
    ("DELETE", "/service/patterns/{service_id}"),
    ("PUT", "/service/exceptions/{day}"),
    ("DELETE", "/service/exceptions/{day}"),
    ("POST", "/incidents/{incident_id}/acknowledge"),
    ("POST", "/incidents/{incident_id}/close"),
    ("GET", "/incidents/{incident_id}/history"),
    ("POST", "/incidents/{incident_id}/notes"),
    ("GET", "/shift-log"),
    ("POST", "/shift-log"),
    ("POST", "/maps/drafts"),
    ("POST", "/maps/drafts/files"),
    ("PATCH", "/maps/drafts/{draft_id}"),
    ("DELETE", "/maps/drafts/{draft_id}"),
    ("POST", "/maps/drafts/{draft_id}/fixes"),
    ("POST", "/maps/drafts/{draft_id}/publications"),
    ("POST", "/maps/{map_version}/activations"),
    ("POST", "/localization-maps/{map_version}/activations"),
    ("DELETE", "/localization-maps/{map_version}"),
    ("POST", "/vehicles/{vehicle_id}/video-views"),
    ("POST", "/vehicles/{vehicle_id}/camera"),
    ("GET", "/vehicles/{vehicle_id}/camera"),
    ("GET", "/video-segments/{sha256}"),
    ("POST", "/scan-requests"),
    ("POST", "/scan-requests/{request_id}/end"),
    ("POST", "/scan-requests/{request_id}/maps"),
    ("POST", "/map-proposals/{proposal_id}/stop"),
    ("POST", "/map-proposals/{proposal_id}/publication"),
    ("POST", "/map-proposals/{proposal_id}/dismissal"),
}
BY_TOKEN = [one for one in CHANGES + READING if one not in OPERATORS_ONLY]


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerUnderTest]:
    many = {"login_tries_per_minute": 100_000, "account_login_tries_per_minute": 100_000}
    server = ServerUnderTest(tmp_path_factory.mktemp("var"), commands_per_minute=100_000, **many)
    yield server
    server.close()


def token(server: ServerUnderTest, *scopes: str) -> dict[str, str]:
    def work(uow: UnitOfWork) -> str:
        return identity.create_developer_token(uow, "script", scopes, 3600.0, "operator").secret  # type: ignore[arg-type]

    return {"Authorization": f"Bearer {server.transact(work)}"}


def test_what_stays_with_operators_is_part_of_the_api() -> None:
    assert set(CHANGES + READING) >= OPERATORS_ONLY


@pytest.mark.parametrize("operation", BY_TOKEN, ids=" ".join)
def test_the_scope_opens_the_endpoint(running: ServerUnderTest, operation: tuple[str, str]) -> None:
    scope = "read" if operation[0] == "GET" else "drive"
    answer = ask(running, operation, headers=token(running, scope))
    assert answer.status_code not in (401, 403), answer.text


@pytest.mark.parametrize("operation", BY_TOKEN, ids=" ".join)
def test_the_other_scopes_do_not_open_it(running: ServerUnderTest, operation: tuple[str, str]) -> None:
    others = ("drive", "infrastructure") if operation[0] == "GET" else ("read", "infrastructure")
    answer = ask(running, operation, headers=token(running, *others))
    assert (answer.status_code, answer.json()["code"]) == (403, "scope_missing")


@pytest.mark.parametrize("operation", BY_TOKEN, ids=" ".join)
def test_a_wrong_token_opens_nothing_even_beside_a_session(
    running: ServerUnderTest, operation: tuple[str, str]
) -> None:
    csrf = running.sign_in()
    answer = ask(running, operation, headers=csrf | {"Authorization": "Bearer not-a-token"})
    running.client.cookies.clear()
    assert (answer.status_code, answer.json()["code"]) == (401, "token_invalid")
    assert answer.headers["WWW-Authenticate"] == "Bearer"


@pytest.mark.parametrize("operation", sorted(OPERATORS_ONLY), ids=" ".join)
def test_no_token_opens_what_stays_with_operators(
    running: ServerUnderTest, operation: tuple[str, str]
) -> None:
    answer = ask(running, operation, headers=token(running, "read", "drive"))
    assert (answer.status_code, answer.json()["code"]) == (401, "session_expired")


def test_a_revoked_token_ends_at_its_next_request(server: ServerUnderTest) -> None:
    def make(uow: UnitOfWork) -> identity.CreatedToken:
        return identity.create_developer_token(uow, "script", ["read"], 3600.0, "operator")

    made = server.transact(make)
    headers = {"Authorization": f"Bearer {made.secret}"}
    assert server.get("/vehicles", headers=headers).status_code == 200
    server.transact(lambda uow: identity.revoke_developer_token(uow, made.token.token_id, "operator"))
    assert server.get("/vehicles", headers=headers).json()["code"] == "token_invalid"


def test_a_booking_with_a_wrong_token_is_refused_instead_of_made_for_a_passenger(
    server: ServerUnderTest,
) -> None:
    wish = {"from_stop": "NN7", "to_stop": "C6"}
    answer = server.post("/rides", wish, headers={"Authorization": "Bearer not-a-token"})
    assert (answer.status_code, answer.json()["code"]) == (401, "token_invalid")
    server.sign_in()
    assert server.get("/rides").json() == []
