"""Who may change what: every endpoint that changes something, from the application's own routes."""

from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from server.api.routers import PREFIX, bare_app
from tests.server.api.server_under_test import ServerUnderTest

# Passengers have no accounts: a ride's token is its key. Vehicles sign what they send.
PUBLIC_CHANGES = {
    ("POST", "/rides"),
    ("POST", "/rides/{token}/cancel"),
    ("POST", "/rides/{token}/destination"),
    ("POST", "/rides/{token}/board"),
    ("POST", "/rides/{token}/alight"),
    ("POST", "/rides/{token}/help"),
    ("POST", "/rides/{token}/feedback"),
    ("PUT", "/rides/{token}/notices"),
    ("DELETE", "/rides/{token}/notices/{subscription_id}"),
    ("POST", "/rides/offers"),
    ("POST", "/series"),
    ("POST", "/series/{token}/cancel"),
    ("POST", "/series/{token}/days/{day}/cancel"),
    ("POST", "/session"),
    ("POST", "/enrolments"),
    ("PUT", "/runs/segments/{sha256}"),
    ("PUT", "/scan-parcels/{sha256}"),
    ("PUT", "/video-segments/{sha256}"),
}
PUBLIC_READING = {
    ("GET", "/campus"),
    ("GET", "/stops"),
    ("GET", "/campus/map"),
    ("GET", "/campus/notices"),
    # By a vehicle's signature.
    ("GET", "/maps/{map_version}/vehicle-file"),
    ("GET", "/localization-maps/{map_version}/vehicle-manifest"),
    ("GET", "/localization-maps/{map_version}/vehicle-tiles/{sha256}"),
    ("GET", "/announcements/current"),
    ("GET", "/stops/{stop_id}/board"),
    ("GET", "/stops/{stop_id}/board/code"),
    ("GET", "/rides/lookup"),
    ("GET", "/rides/{token}"),
    ("GET", "/rides/{token}/taps/{tap_id}"),
    ("GET", "/series/{token}"),
    ("GET", "/timetable"),
    ("GET", "/health"),
    ("GET", "/ready"),
}
EXAMPLES = {"day": "2026-11-23", "sha256": 64 * "0"}


def operations() -> list[tuple[str, str]]:
    """(method, path) of every endpoint, the prefix left out."""
    paths = bare_app().openapi()["paths"]
    return [
        (method.upper(), path.removeprefix(PREFIX)) for path, methods in paths.items() for method in methods
    ]


CHANGES = [one for one in operations() if one[0] != "GET" and one not in PUBLIC_CHANGES]
READING = [one for one in operations() if one[0] == "GET" and one not in PUBLIC_READING]


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerUnderTest]:
    server = ServerUnderTest(tmp_path_factory.mktemp("var"))
    yield server
    server.close()


@pytest.fixture(scope="module")
def session(running: ServerUnderTest) -> str:
    """The cookie of an operator who is signed in."""
    running.sign_in()
    cookie: str = running.client.cookies["campusloop_session"]
    running.client.cookies.clear()
    return cookie


def ask(server: ServerUnderTest, operation: tuple[str, str], **options: object) -> httpx.Response:
    method, path = operation
    for name, example in EXAMPLES.items():
        path = path.replace("{" + name + "}", example)
    return server.request(method, path.replace("{", "").replace("}", ""), **options)


def test_whoever_adds_a_public_endpoint_adds_it_to_this_list() -> None:
    assert set(operations()) >= PUBLIC_CHANGES | PUBLIC_READING
    assert len(CHANGES) >= 30
    assert len(READING) >= 15


@pytest.mark.parametrize("operation", CHANGES + READING, ids=" ".join)
def test_without_a_session_nothing_is_shown_and_nothing_is_changed(
    running: ServerUnderTest, operation: tuple[str, str]
) -> None:
    answer = ask(running, operation)
    assert (answer.status_code, answer.json()["code"]) == (401, "session_expired")


@pytest.mark.parametrize("operation", CHANGES, ids=" ".join)
def test_a_cookie_alone_which_another_site_may_have_sent_changes_nothing(
    running: ServerUnderTest, session: str, operation: tuple[str, str]
) -> None:
    cookie = {"Cookie": f"campusloop_session={session}"}
    for token in ({}, {"X-CSRF-Token": ""}, {"X-CSRF-Token": "guess"}):
        answer = ask(running, operation, headers=cookie | token)
        assert (answer.status_code, answer.json()["code"]) == (403, "csrf_missing")


def test_the_csrf_token_of_another_session_changes_nothing(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path)
    others = server.sign_in()
    server.client.cookies.clear()
    mine = server.sign_in()
    assert server.request("DELETE", "/session", headers=others).status_code == 403
    assert server.request("DELETE", "/session", headers=mine).status_code == 204
    server.close()
