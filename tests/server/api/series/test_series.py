"""Recurring bookings, and rides that change on the way, over REST."""

import pytest

from server.loops.series import SeriesScheduler
from tests.server.api.rides.test_rides import book, campus
from tests.server.api.server_under_test import ServerUnderTest

__all__ = ["campus"]

WISH = {
    "from_stop": "NN20",
    "to_stop": "C6",
    "weekdays": [0, 1, 2, 3, 4],
    "leave": "16:30",
    "ends_on": "2026-09-11",
}


def beat(server: ServerUnderTest) -> None:
    server.run(SeriesScheduler(server.transactions, "clerk").run_once())


def test_each_day_is_shown_with_its_ride(campus: ServerUnderTest) -> None:
    answer = campus.post("/series", WISH)
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert (made["leave"], made["timezone"], made["starts_on"]) == ("16:30", "Asia/Shanghai", "2026-09-01")
    beat(campus)
    shown = campus.get(f"/series/{made['token']}").json()
    today, tomorrow = shown["days"][:2]
    assert (today["day"], today["leave_at"], today["state"]) == (
        "2026-09-01",
        "2026-09-01T08:30:00Z",
        "booked",
    )
    assert today["ride"]["promise"]["pickup_from"] >= today["leave_at"]
    assert campus.get(f"/rides/{today['ride']['token']}").json()["ride_id"] == today["ride"]["ride_id"]
    assert (tomorrow["state"], tomorrow["ride"]) == ("planned", None)
    assert len(shown["days"]) == 9


def test_one_day_and_then_all_are_cancelled(campus: ServerUnderTest) -> None:
    token = campus.post("/series", WISH).json()["token"]
    beat(campus)
    after = campus.post(f"/series/{token}/days/2026-09-01/cancel").json()
    assert (after["days"][0]["state"], after["days"][0]["ride"]["state"]) == ("cancelled", "cancelled")
    again = campus.post(f"/series/{token}/days/2026-09-01/cancel")
    assert (again.status_code, again.json()["code"]) == (409, "occurrence_ended")
    none = campus.post(f"/series/{token}/days/2026-09-05/cancel")
    assert (none.status_code, none.json()["code"]) == (404, "series_unknown")
    gone = campus.post(f"/series/{token}/cancel").json()
    assert (gone["state"], [day["state"] for day in gone["days"]]) == ("cancelled", ["cancelled"])
    assert campus.post(f"/series/{token}/cancel").json()["code"] == "series_ended"


def test_why_nobody_can_take_a_day_is_told(server: ServerUnderTest) -> None:
    token = server.post("/series", WISH).json()["token"]
    beat(server)
    today = server.get(f"/series/{token}").json()["days"][0]
    assert (today["state"], today["reason"]) == ("trying", "no_vehicle_free")
    assert today["reason_detail"] == "no shuttle is in service at that time"


def test_operators_see_and_cancel_recurring_bookings(campus: ServerUnderTest) -> None:
    campus.post("/series", WISH)
    assert campus.get("/series").status_code == 401
    headers = campus.sign_in()
    (record,) = campus.get("/series").json()
    assert (record["state"], record["source"], "token" in record) == ("active", "passenger", False)
    gone = campus.post(f"/series/id/{record['series_id']}/cancel", headers=headers).json()
    assert gone["state"] == "cancelled"
    assert campus.get("/series", params={"state": "active"}).json() == []


def test_a_repeat_with_the_same_key_is_one_booking(campus: ServerUnderTest) -> None:
    headers = {"Idempotency-Key": "6f1d0c1e-2b7a"}
    first = campus.post("/series", WISH, headers=headers).json()
    assert campus.post("/series", WISH, headers=headers).json()["series_id"] == first["series_id"]
    other = campus.post("/series", WISH | {"leave": "17:00"}, headers=headers)
    assert (other.status_code, other.json()["code"]) == (409, "idempotency_mismatch")


@pytest.mark.parametrize(
    ("changes", "status", "code"),
    [
        ({"to_stop": "the-moon"}, 404, "stop_unknown"),
        ({"to_stop": "NN20"}, 400, "same_stop"),
        ({"ends_on": "2026-08-31"}, 400, "series_invalid"),
        ({"ends_on": "2099-08-31"}, 400, "series_invalid"),
        ({"party": 9}, 409, "party_too_large"),
        ({"weekdays": []}, 422, "payload_invalid"),
        ({"leave": "25:00"}, 422, "payload_invalid"),
    ],
)
def test_what_can_never_be_is_refused(
    server: ServerUnderTest, changes: dict[str, object], status: int, code: str
) -> None:
    answer = server.post("/series", WISH | changes)
    assert (answer.status_code, answer.json()["code"]) == (status, code)


def test_the_destination_changes_and_the_promise_is_told_anew(campus: ServerUnderTest) -> None:
    ride = book(campus)
    changed = campus.post(f"/rides/{ride['token']}/destination", {"to_stop": "GYM"})
    assert changed.status_code == 200, changed.text
    after = changed.json()
    assert (after["to_stop"], after["first_to_stop"], after["let_out"]) == ("GYM", "C6", False)
    assert after["promise"]["arrive_by"] > ride["promise"]["arrive_by"]  # type: ignore[index]
    assert after["promise"]["pickup_to"] == ride["promise"]["pickup_to"]  # type: ignore[index]


def test_a_refused_change_names_the_rule_and_leaves_the_ride(campus: ServerUnderTest) -> None:
    ride = book(campus)
    headers = campus.sign_in()
    campus.post("/vehicles/shuttle-1/recall", headers=headers)
    refused = campus.post(f"/rides/{ride['token']}/destination", {"to_stop": "GYM"})
    assert (refused.status_code, refused.json()["code"]) == (409, "destination_refused")
    assert refused.json()["rule"] == "no_vehicle_free"
    assert campus.get(f"/rides/{ride['token']}").json()["to_stop"] == "C6"
    record = campus.post(f"/rides/id/{ride['ride_id']}/destination", {"to_stop": "the-moon"}, headers=headers)
    assert (record.status_code, record.json()["code"]) == (404, "stop_unknown")


def test_the_day_s_ride_carries_its_series_for_operators(campus: ServerUnderTest) -> None:
    made = campus.post("/series", WISH).json()
    beat(campus)
    campus.sign_in()
    (record,) = campus.get("/rides").json()
    assert record["series_id"] == made["series_id"]


def test_an_operator_erases_a_series_with_its_rides(campus: ServerUnderTest) -> None:
    made = campus.post("/series", WISH).json()
    beat(campus)
    done = campus.post(f"/series/id/{made['series_id']}/erase", headers=campus.sign_in())
    assert (done.status_code, done.json()) == (200, {"rides": 1})
    assert campus.get(f"/series/{made['token']}").status_code == 404
    (record,) = campus.get("/rides").json()
    assert (record["ride_code"], record["series_id"]) == ("", None)
