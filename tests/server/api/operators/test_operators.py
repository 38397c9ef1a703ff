"""Operators through the API: made by admins, with a password that opens nothing but its change."""

from typing import Any

import pytest

from tests.server.api.server_under_test import ServerUnderTest

OWN = "an own long password"


@pytest.fixture
def admin(server: ServerUnderTest) -> dict[str, str]:
    return server.sign_in()


def make(server: ServerUnderTest, admin: dict[str, str], name: str, *roles: str) -> str:
    answer = server.post("/operators", {"name": name, "roles": list(roles)}, headers=admin)
    assert answer.status_code == 201, answer.text
    password: str = answer.json()["initial_password"]
    return password


def sign_in(server: ServerUnderTest, name: str, password: str) -> tuple[dict[str, str], dict[str, Any]]:
    server.client.cookies.clear()
    answer = server.post("/session", {"name": name, "password": password})
    assert answer.status_code == 200, answer.text
    return {"X-CSRF-Token": answer.json()["csrf_token"]}, answer.json()


def test_an_initial_password_opens_nothing_but_its_change(
    server: ServerUnderTest, admin: dict[str, str]
) -> None:
    initial = make(server, admin, "ann", "dispatcher")
    ann, session = sign_in(server, "ann", initial)
    assert session["password_change_needed"]
    assert server.get("/vehicles").json()["code"] == "password_change_needed"
    change = {"password": initial, "new_password": OWN}
    assert not server.post("/session/password", change, headers=ann).json()["password_change_needed"]
    assert server.get("/vehicles").status_code == 200
    sign_in(server, "ann", OWN)


def test_a_password_is_changed_only_by_one_who_knows_it(
    server: ServerUnderTest, admin: dict[str, str]
) -> None:
    ann, _ = sign_in(server, "ann", make(server, admin, "ann"))
    change = {"password": "a guess", "new_password": OWN}
    answer = server.post("/session/password", change, headers=ann)
    assert answer.json()["code"] == "wrong_credentials"


def test_a_role_taken_away_is_gone_at_the_next_request(
    server: ServerUnderTest, admin: dict[str, str]
) -> None:
    initial = make(server, admin, "ann", "admin")
    operator_cookies = dict(server.client.cookies)
    ann, _ = sign_in(server, "ann", initial)
    server.post("/session/password", {"password": initial, "new_password": OWN}, headers=ann)
    assert server.get("/operators").status_code == 200
    anns = dict(server.client.cookies)
    server.client.cookies.clear()
    server.client.cookies.update(operator_cookies)
    changed = server.request("PUT", "/operators/ann", json={"roles": ["safety"]}, headers=admin)
    assert changed.json()["roles"] == ["safety", "viewer"]
    server.client.cookies.clear()
    server.client.cookies.update(anns)
    assert server.get("/operators").json()["code"] == "role_missing"


def test_operators_are_listed_without_any_secret(server: ServerUnderTest, admin: dict[str, str]) -> None:
    make(server, admin, "ann", "dispatcher")
    listed = server.get("/operators").json()
    assert [one["name"] for one in listed] == ["ann", "operator"]
    assert "password_hash" not in str(listed)
    assert "plain:" not in str(listed)


def test_the_password_of_the_settings_is_not_changed_here(server: ServerUnderTest) -> None:
    admin = server.sign_in()
    settings = server.services.settings.model_copy(update={"operator_password": "correct horse battery"})
    object.__setattr__(server.services, "settings", settings)
    change = {"password": "correct horse battery", "new_password": OWN}
    assert server.post("/session/password", change, headers=admin).json()["code"] == "password_in_settings"
    reset = server.post("/operators/operator/password", headers=admin)
    assert reset.json()["code"] == "password_in_settings"
