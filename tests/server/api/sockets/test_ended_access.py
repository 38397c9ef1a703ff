"""Open connections end with the session or token that opened them, within two seconds."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from server.domain.errors import StoreUnavailable
from server.domain.rules import FleetRules
from server.supervision.retries import RetryPolicy
from server.usecases.ports import topics
from server.usecases.record import identity
from server.usecases.record.identity import CreatedToken
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.api.sockets.open_socket import OpenSocket, bearer

SESSION_S = 500.0
SOON_S = 2.0


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerUnderTest]:
    # The scene feed outlives an outage of the database as well.
    enduring = RetryPolicy(failures_max=1000)
    server = ServerUnderTest(tmp_path, rules=FleetRules(operator_session_s=SESSION_S), retry=enduring)
    yield server
    server.close()


def a_token(server: ServerUnderTest, scope: str, valid_s: float = 3600.0) -> CreatedToken:
    created: CreatedToken = server.transact(
        lambda uow: identity.create_developer_token(uow, "script", [scope], valid_s, "operator")
    )
    return created


def an_operators_view(server: ServerUnderTest) -> OpenSocket:
    cookie = f"campusloop_session={server.client.cookies['campusloop_session']}"
    view = OpenSocket(server, "/ws/live", (b"cookie", cookie.encode()))
    view.say('{"type":"watch"}')
    assert json.loads(view.texts[-1])["type"] == "snapshot"
    return view


@pytest.mark.parametrize(
    ("path", "scope"), [("/ws/developer", "read"), ("/ws/infrastructure", "infrastructure")]
)
def test_a_revoked_token_ends_a_silent_connection(server: ServerUnderTest, path: str, scope: str) -> None:
    token = a_token(server, scope)
    opened = OpenSocket(server, path, bearer(token.secret))
    other = OpenSocket(server, path, bearer(a_token(server, scope).secret))
    server.elapse(60.0)
    assert opened.closed is None
    server.transact(lambda uow: identity.revoke_developer_token(uow, token.token.token_id, "operator"))
    server.elapse(SOON_S)
    assert opened.closed == 4401
    assert "token_invalid" in opened.texts[-1]
    assert opened.task.done()
    assert other.closed is None


@pytest.mark.parametrize(
    ("path", "scope"), [("/ws/developer", "read"), ("/ws/infrastructure", "infrastructure")]
)
def test_a_token_that_expires_ends_a_silent_connection(
    server: ServerUnderTest, path: str, scope: str
) -> None:
    opened = OpenSocket(server, path, bearer(a_token(server, scope, valid_s=100.0).secret))
    server.elapse(98.0)
    assert opened.closed is None
    server.elapse(SOON_S + 1.0)
    assert opened.closed == 4401


def test_signing_out_ends_the_operators_live_views(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    view = an_operators_view(server)
    assert server.request("DELETE", "/session", headers=headers).status_code == 204
    server.elapse(SOON_S)
    assert view.closed == 4403
    assert json.loads(view.texts[-1])["code"] == "session_expired"


def test_a_changed_password_ends_the_operators_live_views(server: ServerUnderTest) -> None:
    server.sign_in()
    view = an_operators_view(server)
    server.transact(lambda uow: identity.set_password(uow, "operator", "another one"))
    server.elapse(SOON_S)
    assert view.closed == 4403


def test_an_expired_session_ends_the_operators_live_views(server: ServerUnderTest) -> None:
    server.sign_in()
    view = an_operators_view(server)
    server.elapse(SESSION_S - 5.0)
    assert view.closed is None
    server.elapse(SOON_S + 5.0)
    assert view.closed == 4403


def test_a_passenger_goes_on_watching_while_operators_come_and_go(server: ServerUnderTest) -> None:
    ride = server.post("/rides", {"from_stop": "NN20", "to_stop": "C6"}).json()
    view = OpenSocket(server, "/ws/live", (b"accept", b"*/*"))
    view.say(json.dumps({"type": "watch", "ride_token": ride["token"]}))
    headers = server.sign_in()
    server.request("DELETE", "/session", headers=headers)
    server.elapse(SESSION_S + 60.0)
    assert view.closed is None


def test_a_database_that_does_not_answer_ends_no_connection(
    server: ServerUnderTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def lost(work: object) -> None:
        raise StoreUnavailable("out of reach")

    headers = server.sign_in()
    view = an_operators_view(server)
    script = OpenSocket(server, "/ws/developer", bearer(a_token(server, "read").secret))
    with monkeypatch.context() as outage:
        outage.setattr(server.transactions, "read", lost)
        server.run(server.bus.publish(topics.access("snow-lion"), b"{}"))
        server.elapse(10.0)
    assert (view.closed, script.closed) == (None, None)
    assert server.request("DELETE", "/session", headers=headers).status_code == 204
    server.elapse(SOON_S)
    assert view.closed == 4403


@pytest.mark.parametrize(
    ("path", "scope"), [("/ws/developer", "read"), ("/ws/infrastructure", "infrastructure")]
)
def test_a_connection_that_is_opened_without_a_database_is_told_to_come_again(
    server: ServerUnderTest, monkeypatch: pytest.MonkeyPatch, path: str, scope: str
) -> None:
    async def lost(work: object) -> None:
        raise StoreUnavailable("out of reach")

    token = a_token(server, scope)
    with monkeypatch.context() as outage:
        outage.setattr(server.transactions, "read", lost)
        opened = OpenSocket(server, path, bearer(token.secret))
        if path == "/ws/infrastructure":
            opened.say(json.dumps({"type": "presence_report", "area_id": "zebra", "count": 1}))
    assert opened.closed == 1013
    assert "store_unavailable" in opened.texts[-1]
