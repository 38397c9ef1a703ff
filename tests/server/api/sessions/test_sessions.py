from pathlib import Path

import pytest

from server.domain.rules import FleetRules
from tests.server.api.server_under_test import PASSWORD, ServerUnderTest

CREDENTIALS = {"name": "operator", "password": PASSWORD}


def test_signing_in_sets_a_cookie_that_scripts_and_other_sites_cannot_use(server: ServerUnderTest) -> None:
    answer = server.post("/session", CREDENTIALS)
    assert answer.status_code == 200
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert "Secure" not in cookie
    token = server.client.cookies["campusloop_session"]
    assert token not in answer.text
    me = server.get("/session").json()
    assert (me["name"], me["csrf_token"]) == ("operator", answer.json()["csrf_token"])


def test_behind_tls_the_cookie_is_secure(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, public_url="https://campus.example")
    assert "Secure" in server.post("/session", CREDENTIALS).headers["set-cookie"]
    server.close()


@pytest.mark.parametrize("wrong", [{"password": "guess"}, {"name": "nobody"}])
def test_wrong_credentials_do_not_say_what_was_wrong(server: ServerUnderTest, wrong: dict[str, str]) -> None:
    answer = server.post("/session", CREDENTIALS | wrong)
    assert answer.status_code == 401
    assert answer.json()["code"] == "wrong_credentials"
    assert answer.headers["content-type"] == "application/problem+json"
    assert "set-cookie" not in answer.headers


def test_guessing_passwords_is_slowed_down_by_our_clock(server: ServerUnderTest) -> None:
    tries = [server.post("/session", CREDENTIALS | {"password": str(n)}).status_code for n in range(7)]
    assert tries == [401] * 6 + [429]
    refused = server.post("/session", CREDENTIALS)
    assert refused.status_code == 429
    assert int(refused.headers["retry-after"]) >= 1
    server.elapse(12.0)
    assert server.post("/session", CREDENTIALS).status_code == 200


def test_who_guesses_passwords_slows_nobody_else_down(server: ServerUnderTest) -> None:
    for number in range(7):
        server.post("/session", CREDENTIALS | {"password": str(number)})
    assert server.post("/session", CREDENTIALS).status_code == 429
    server.from_host("10.0.0.7")
    assert server.post("/session", CREDENTIALS).status_code == 200


def test_a_change_needs_the_csrf_token_beside_the_cookie(server: ServerUnderTest) -> None:
    change = {"name": "script", "scopes": ["read"]}
    assert server.post("/developer-tokens", change).json()["code"] == "session_expired"
    headers = server.sign_in()
    assert server.post("/developer-tokens", change).json()["code"] == "csrf_missing"
    wrong = {"X-CSRF-Token": "x" + headers["X-CSRF-Token"][1:]}
    assert server.post("/developer-tokens", change, headers=wrong).status_code == 403
    assert server.post("/developer-tokens", change, headers=headers).status_code == 201


def test_a_session_ends_by_our_clock(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, rules=FleetRules(operator_session_s=30.0))
    server.sign_in()
    assert server.get("/session").status_code == 200
    server.elapse(31.0)
    ended = server.get("/session")
    assert (ended.status_code, ended.json()["code"]) == (401, "session_expired")
    server.close()


def test_signing_out_ends_the_session_even_for_who_kept_the_cookie(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    token = server.client.cookies["campusloop_session"]
    assert server.request("DELETE", "/session", headers=headers).status_code == 204
    assert "campusloop_session" not in server.client.cookies
    kept = server.get("/session", headers={"Cookie": f"campusloop_session={token}"})
    assert kept.status_code == 401
