"""The second factor at the API: what asks for it, and what never does."""

from pathlib import Path
from typing import Any

import pyotp
import pytest

from tests.server.api.server_under_test import PASSWORD, ServerUnderTest

MOVES = (
    ("POST", "/vehicles/shuttle-1/resume"),
    ("POST", "/vehicles/shuttle-1/recall"),
    ("POST", "/vehicles/shuttle-1/release"),
    ("POST", "/vehicles/shuttle-1/send?stop_id=NN7"),
    ("PUT", "/vehicles/shuttle-1/place"),
    ("POST", "/developer-tokens"),
    ("POST", "/operators"),
    ("PUT", "/operators/ann"),
    ("POST", "/operators/ann/password"),
    ("DELETE", "/operators/ann/second-factor"),
)
STOPS = (
    ("POST", "/vehicles/shuttle-1/hold"),
    ("POST", "/vehicles/shuttle-1/stop-now"),
    ("POST", "/vehicles/shuttle-1/evacuations"),
)
BODIES: dict[str, Any] = {
    "/vehicles/shuttle-1/place": {"lane_id": "x", "s_m": 1.0},
    "/developer-tokens": {"name": "script", "scopes": ["drive"]},
    "/operators": {"name": "bob", "roles": []},
    "/operators/ann": {"roles": []},
}


def enrol(server: ServerUnderTest) -> tuple[dict[str, str], pyotp.TOTP, list[str]]:
    csrf = server.sign_in()
    made = server.post("/session/second-factor", {"password": PASSWORD}, headers=csrf).json()
    assert "<svg" in made["qr_svg"]
    totp = pyotp.TOTP(made["secret"])
    code = {"code": totp.at(server.clock.now())}
    confirmed = server.post("/session/second-factor/confirmation", code, headers=csrf).json()
    server.elapse(30.0)
    return csrf, totp, confirmed["recovery_codes"]


def code_of(server: ServerUnderTest, operation: tuple[str, str], csrf: dict[str, str]) -> str:
    method, path = operation
    answer = server.request(method, path, json=BODIES.get(path), headers=csrf)
    body = answer.json()
    return str(body["code"]) if "code" in body else ""


@pytest.mark.parametrize("operation", MOVES, ids=" ".join)
def test_a_new_session_moves_nothing_and_gives_no_access_before_the_check(
    server: ServerUnderTest, operation: tuple[str, str]
) -> None:
    _, totp, _ = enrol(server)
    csrf = server.sign_in()
    assert code_of(server, operation, csrf) == "second_factor_needed"
    given = {"code": totp.at(server.clock.now())}
    assert server.post("/session/second-factor/checks", given, headers=csrf).status_code == 200
    assert code_of(server, operation, csrf) != "second_factor_needed"


@pytest.mark.parametrize("operation", STOPS, ids=" ".join)
def test_stopping_never_asks_for_it(tmp_path: Path, operation: tuple[str, str]) -> None:
    server = ServerUnderTest(tmp_path, second_factor_required=True)
    assert code_of(server, operation, server.sign_in()) == "vehicle_unknown"
    server.close()


def test_the_settings_make_it_compulsory(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, second_factor_required=True)
    csrf = server.sign_in()
    assert code_of(server, MOVES[0], csrf) == "second_factor_missing"
    server.close()


def test_the_check_is_over_after_its_hours(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, second_factor_hours=0.02)
    csrf, _, _ = enrol(server)
    assert code_of(server, MOVES[0], csrf) == "vehicle_unknown"
    server.elapse(server.settings.second_factor_hours * 3600.0)
    assert code_of(server, MOVES[0], csrf) == "second_factor_needed"
    server.close()


def test_guesses_have_a_budget(server: ServerUnderTest) -> None:
    csrf, _, _ = enrol(server)
    codes = [
        server.post("/session/second-factor/checks", {"code": "000000"}, headers=csrf).json().get("code")
        for _ in range(server.settings.second_factor_tries_per_minute + 1)
    ]
    assert codes[-1] == "too_many_tries"


def test_only_the_one_who_has_it_replaces_or_removes_it(server: ServerUnderTest) -> None:
    enrol(server)
    csrf = server.sign_in()
    begin = server.post("/session/second-factor", {"password": PASSWORD}, headers=csrf)
    assert begin.json()["code"] == "second_factor_needed"
    removed = server.request("DELETE", "/session/second-factor", headers=csrf)
    assert removed.json()["code"] == "second_factor_needed"


def test_it_is_begun_only_by_one_who_knows_the_password(server: ServerUnderTest) -> None:
    csrf = server.sign_in()
    begin = server.post("/session/second-factor", {"password": "a guess"}, headers=csrf)
    assert begin.json()["code"] == "wrong_credentials"
