"""Calendars and the day's timetable over REST."""

import pytest

from tests.server.api.server_under_test import ServerUnderTest

TERM = {
    "name": "Term",
    "weekdays": [0, 1, 2, 3, 4],
    "starts_on": "2026-08-01",
    "hours": [{"opens": "07:30", "closes": "25:00"}],
}


@pytest.fixture
def operator(server: ServerUnderTest) -> dict[str, str]:
    return server.sign_in() | {"Content-Type": "application/json"}


def put(server: ServerUnderTest, path: str, body: object, headers: dict[str, str]) -> dict[str, object]:
    answer = server.request("PUT", path, json=body, headers=headers)
    assert answer.status_code == 200, answer.text
    found: dict[str, object] = answer.json()
    return found


def test_everybody_sees_the_day_s_timetable_with_its_last_run(server: ServerUnderTest) -> None:
    day = server.get("/timetable").json()
    assert (day["day"], day["timezone"], day["holiday"]) == ("2026-09-01", "Asia/Shanghai", None)
    assert [trip["trip_id"] for trip in day["trips"] if trip["is_last_run"]] == ["evening-3"]
    assert {trip["service_id"] for trip in day["trips"]} == {"daily"}
    last = next(trip for trip in day["trips"] if trip["is_last_run"])
    assert all(call["is_last"] for call in last["calls"])
    assert server.get("/campus").json()["last_run_at"] == last["calls"][0]["leave_at"]
    assert server.get("/timetable", params={"day": "2026-12-24"}).json()["day"] == "2026-12-24"


def test_a_calendar_is_entered_changed_listed_and_removed(
    server: ServerUnderTest, operator: dict[str, str]
) -> None:
    made = put(server, "/service/patterns/term", TERM, operator)
    assert made == TERM | {"service_id": "term", "ends_on": None, "trips": 0}
    put(server, "/service/patterns/term", TERM | {"name": "Autumn term"}, operator)
    listed = server.get("/service").json()
    assert [(p["service_id"], p["name"], p["trips"]) for p in listed["patterns"]] == [
        ("daily", "daily", 13),
        ("term", "Autumn term", 0),
    ]
    assert server.get("/campus").json()["closes_at"] == "2026-09-01T17:00:00Z"
    assert server.request("DELETE", "/service/patterns/term", headers=operator).status_code == 204
    again = server.request("DELETE", "/service/patterns/term", headers=operator)
    assert (again.status_code, again.json()["code"]) == (404, "pattern_unknown")


def test_a_holiday_closes_the_campus_and_is_taken_back(
    server: ServerUnderTest, operator: dict[str, str]
) -> None:
    made = put(server, "/service/exceptions/2026-09-01", {"note": "Founding Day"}, operator)
    assert made == {
        "day": "2026-09-01",
        "service_id": "",
        "runs": False,
        "note": "Founding Day",
        "made_by": "operator",
    }
    campus = server.get("/campus").json()
    assert (campus["open_now"], campus["holiday"]) == (False, "Founding Day")
    assert campus["opens_next"] == "2026-09-01T16:00:00Z"
    refused = server.post("/rides", {"from_stop": "NN20", "to_stop": "C6"}).json()
    assert (refused["code"], "Wednesday 02 September 00:00" in refused["detail"]) == ("no_service", True)
    assert server.get("/timetable").json()["trips"] == []
    path = "/service/exceptions/2026-09-01"
    assert server.request("DELETE", path, headers=operator).status_code == 204
    assert server.get("/campus").json()["open_now"] is True


def test_one_service_may_run_on_a_holiday(server: ServerUnderTest, operator: dict[str, str]) -> None:
    put(server, "/service/exceptions/2026-09-01", {"note": "Founding Day"}, operator)
    put(server, "/service/exceptions/2026-09-01", {"service_id": "daily", "runs": True}, operator)
    assert len(server.get("/timetable").json()["trips"]) == 13
    assert len(server.get("/service").json()["exceptions"]) == 2


@pytest.mark.parametrize(
    ("path", "body", "status", "code"),
    [
        ("/service/patterns/x", TERM | {"ends_on": "2026-07-01"}, 400, "pattern_invalid"),
        (
            "/service/patterns/x",
            TERM | {"hours": [{"opens": "09:00", "closes": "08:00"}]},
            400,
            "pattern_invalid",
        ),
        (
            "/service/patterns/x",
            TERM | {"hours": [{"opens": "9", "closes": "x"}]},
            422,
            "payload_invalid",
        ),
        ("/service/patterns/x", TERM | {"weekdays": [7]}, 422, "payload_invalid"),
        ("/service/exceptions/2026-09-01", {"service_id": "nobody"}, 404, "pattern_unknown"),
        ("/service/exceptions/9999-12-31", {}, 422, "payload_invalid"),
    ],
)
def test_what_contradicts_itself_is_refused(
    server: ServerUnderTest, operator: dict[str, str], path: str, body: object, status: int, code: str
) -> None:
    answer = server.request("PUT", path, json=body, headers=operator)
    assert (answer.status_code, answer.json()["code"]) == (status, code)


def test_a_calendar_that_the_timetable_runs_by_stays(
    server: ServerUnderTest, operator: dict[str, str]
) -> None:
    answer = server.request("DELETE", "/service/patterns/daily", headers=operator)
    assert (answer.status_code, answer.json()["code"]) == (409, "pattern_in_use")


def test_only_operators_change_the_service(server: ServerUnderTest) -> None:
    assert server.get("/service").status_code == 401
    assert server.request("PUT", "/service/exceptions/2026-09-01", json={}).status_code == 401
