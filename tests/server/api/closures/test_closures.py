"""Closing roads over REST."""

import pytest

from tests.server.api.rides.test_rides import book, campus
from tests.server.api.server_under_test import ServerUnderTest

__all__ = ["campus"]

WISH = {"lane_ids": ["east-4"], "reason": "water main", "ends_at": "2026-09-02T08:00:00Z"}


@pytest.fixture
def operator(server: ServerUnderTest) -> dict[str, str]:
    return server.sign_in() | {"Content-Type": "application/json"}


def close(server: ServerUnderTest, body: object, headers: dict[str, str]) -> tuple[int, dict[str, object]]:
    answer = server.request("POST", "/closures", json=body, headers=headers)
    return answer.status_code, answer.json()


def test_a_road_is_closed_listed_and_opened_again(server: ServerUnderTest, operator: dict[str, str]) -> None:
    status, made = close(server, WISH, operator)
    assert status == 201
    assert made["lane_ids"] == ["east-4"]
    assert made["state"] == "in_force"
    assert (made["reason"], made["made_by"], made["ends_at"]) == (
        "water main",
        "operator",
        "2026-09-02T08:00:00Z",
    )
    lines = made["lines"]
    assert isinstance(lines, list)
    assert all(len(line) >= 4 and len(line) % 2 == 0 for line in lines)
    assert server.get("/closures").json() == [made]
    path = f"/closures/{made['closure_id']}"
    assert server.request("DELETE", path, headers=operator).status_code == 204
    assert server.get("/closures").json() == []
    again = server.request("DELETE", path, headers=operator)
    assert (again.status_code, again.json()["code"]) == (409, "closure_over")


@pytest.mark.parametrize(
    ("body", "status", "code"),
    [
        ({"lane_ids": ["nowhere"]}, 404, "lane_unknown"),
        ({"section_ids": ["nowhere"]}, 404, "section_unknown"),
        ({}, 400, "closure_invalid"),
        (WISH | {"starts_at": "2026-09-03T08:00:00Z"}, 400, "closure_invalid"),
        (WISH | {"ends_at": "2026-08-01T08:00:00Z"}, 400, "closure_invalid"),
        (WISH | {"ends_at": "tomorrow"}, 422, "payload_invalid"),
        (WISH | {"lanes": ["east-4"]}, 422, "payload_invalid"),
    ],
)
def test_what_cannot_be_closed_is_refused_by_name(
    server: ServerUnderTest, operator: dict[str, str], body: object, status: int, code: str
) -> None:
    found, problem = close(server, body, operator)
    assert (found, problem["code"]) == (status, code)
    assert server.get("/closures").json() == []


def test_only_operators_close_and_see_closures(server: ServerUnderTest) -> None:
    assert server.get("/closures").status_code == 401
    assert close(server, WISH, {})[0] == 401
    unknown = server.request("DELETE", "/closures/closure-0", headers=server.sign_in())
    assert (unknown.status_code, unknown.json()["code"]) == (404, "closure_unknown")


def test_a_preview_tells_which_rides_end_and_changes_nothing(campus: ServerUnderTest) -> None:
    ride = book(campus)
    headers = campus.sign_in()
    lanes = [lane["lane_id"] for lane in campus.get("/campus/map").json()["lanes"]]
    body = {"lane_ids": lanes}
    previewed = campus.post("/closures/previews", body, headers=headers)
    assert previewed.status_code == 200, previewed.text
    (effect,) = previewed.json()["rides"]
    assert (effect["ride_code"], effect["ends"], effect["vehicle_after"]) == (ride["ride_code"], True, None)
    assert campus.get("/closures").json() == []
    assert campus.get(f"/rides/{ride['token']}").json()["state"] == "assigned"
    assert campus.post("/closures", body, headers=headers).status_code == 201
    assert campus.get(f"/rides/{ride['token']}").json()["state"] == "failed"


def test_a_preview_is_refused_as_the_closure_would_be(
    server: ServerUnderTest, operator: dict[str, str]
) -> None:
    for body, status in (({"lane_ids": ["nowhere"]}, 404), ({}, 400)):
        assert server.request("POST", "/closures/previews", json=body, headers=operator).status_code == status
    assert server.request("POST", "/closures/previews", json=WISH).status_code in (401, 403)
