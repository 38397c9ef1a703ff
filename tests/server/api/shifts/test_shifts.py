"""Shifts over REST."""

import pytest

from tests.server.api.server_under_test import ServerUnderTest

DAY = [{"begins": "07:30", "ends": "25:00"}]
SHIFTS = {"weekly": [DAY] * 5 + [[], []], "exceptions": [{"day": "2026-10-01", "shifts": []}]}
PATH = "/vehicles/shuttle-1/shifts"


@pytest.fixture
def operator(server: ServerUnderTest) -> dict[str, str]:
    headers = server.sign_in() | {"Content-Type": "application/json"}
    wish = {"vehicle_id": "shuttle-1", "name": "One", "seats": 6, "wheelchair_places": 0}
    assert server.request("POST", "/enrolments/codes", json=wish, headers=headers).status_code == 201
    return headers


def test_shifts_are_set_seen_and_taken_away(server: ServerUnderTest, operator: dict[str, str]) -> None:
    assert server.get(PATH).json() is None
    assert server.request("PUT", PATH, json=SHIFTS, headers=operator).json() == SHIFTS
    assert server.get(PATH).json() == SHIFTS
    assert server.request("DELETE", PATH, headers=operator).status_code == 204
    assert server.get(PATH).json() is None


@pytest.mark.parametrize(
    ("body", "status", "code"),
    [
        (SHIFTS | {"weekly": [DAY] * 6}, 422, "payload_invalid"),
        (SHIFTS | {"weekly": [[{"begins": "9", "ends": "10:00"}]] * 7}, 422, "payload_invalid"),
        (SHIFTS | {"weekly": [[{"begins": "09:00", "ends": "08:00"}]] * 7}, 400, "shifts_invalid"),
        (SHIFTS | {"exceptions": [{"day": "2026-10-01"}] * 2}, 400, "shifts_invalid"),
    ],
)
def test_shifts_that_cannot_be_are_refused_by_name(
    server: ServerUnderTest, operator: dict[str, str], body: object, status: int, code: str
) -> None:
    answer = server.request("PUT", PATH, json=body, headers=operator)
    assert (answer.status_code, answer.json()["code"]) == (status, code)


def test_an_unknown_vehicle_has_no_shifts(server: ServerUnderTest, operator: dict[str, str]) -> None:
    answer = server.request("PUT", "/vehicles/shuttle-9/shifts", json=SHIFTS, headers=operator)
    assert (answer.status_code, answer.json()["code"]) == (404, "vehicle_unknown")
