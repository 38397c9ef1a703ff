"""Booking and following a ride, and every booking that cannot be."""

from pathlib import Path

import pytest

from contract.wire.messages import Order
from server.domain.rules import FleetRules
from server.domain.service.timetable import Opening, ServiceHours
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.test_hub import at_rest
from tests.server.fleet.vehicle_key import VehicleKeyPair

WISH = {"from_stop": "NN20", "to_stop": "C6", "party": 2}


@pytest.fixture
def campus(server: ServerUnderTest) -> ServerUnderTest:
    """With one shuttle that stands ready."""
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    server.vehicle = SpokenVehicle(server).dial().hello()  # type: ignore[attr-defined]
    at_rest(server, server.vehicle)  # type: ignore[attr-defined]
    return server


def book(server: ServerUnderTest, **changes: object) -> dict[str, object]:
    answer = server.post("/rides", WISH | changes)
    assert answer.status_code == 201, answer.text
    ride: dict[str, object] = answer.json()
    return ride


def test_a_booking_is_answered_at_once_by_a_vehicle_and_a_promise(campus: ServerUnderTest) -> None:
    ride = book(campus)
    assert (ride["state"], ride["vehicle_id"], ride["party"]) == ("assigned", "shuttle-1", 2)
    promise = ride["promise"]
    assert isinstance(promise, dict)
    assert promise["pickup_from"] < promise["pickup_to"] < promise["arrive_by"]
    assert len(str(ride["ride_code"])) == 6
    assert len(str(ride["boarding_code"])) == 4


def test_a_ticket_tells_a_range_for_the_pickup_and_the_seats_that_are_left(campus: ServerUnderTest) -> None:
    ride = book(campus)
    assert ride["pickup_earliest"] <= ride["pickup_eta"] <= ride["pickup_latest"]  # type: ignore[operator]
    assert ride["seats_left"] == 4
    record = campus.get(f"/rides/lookup?code={ride['ride_code']}").json()
    assert (record["pickup_latest"], record["seats_left"]) == (ride["pickup_latest"], 4)


@pytest.mark.parametrize(
    ("told", "status", "code"),
    [
        ({"rating": 5}, 409, "ride_not_completed"),
        ({"rating": 6}, 422, "payload_invalid"),
        ({"rating": 0}, 422, "payload_invalid"),
        ({}, 422, "payload_invalid"),
        ({"lost_property": "  "}, 422, "payload_invalid"),
        ({"lost_property": "x" * 501}, 422, "payload_invalid"),
        ({"rating": 5, "name": "Ms Wang"}, 422, "payload_invalid"),
    ],
)
def test_feedback_that_cannot_be_is_refused(
    campus: ServerUnderTest, told: dict[str, object], status: int, code: str
) -> None:
    answer = campus.post(f"/rides/{book(campus)['token']}/feedback", told)
    assert (answer.status_code, answer.json()["code"]) == (status, code)


def test_a_look_for_a_free_shuttle_stores_nothing_and_tells_what_a_booking_would_get(
    campus: ServerUnderTest,
) -> None:
    offer = campus.post("/rides/offers", WISH)
    assert offer.status_code == 200, offer.text
    assert offer.json()["is_free"] is True
    assert offer.json()["pickup_at"] == book(campus)["pickup_eta"]
    unknown = campus.post("/rides/offers", WISH | {"to_stop": "the-moon"})
    assert (unknown.status_code, unknown.json()["code"]) == (404, "stop_unknown")


def test_looks_for_a_free_shuttle_have_a_limit_of_their_own(campus: ServerUnderTest) -> None:
    answers = [campus.post("/rides/offers", WISH).status_code for _ in range(61)]
    assert answers == [200] * 60 + [429]
    book(campus)


def test_a_repeat_with_the_same_key_gives_the_same_ride_and_another_wish_is_refused(
    campus: ServerUnderTest,
) -> None:
    headers = {"Idempotency-Key": "6f1d0c1e-2b7a"}
    first = campus.post("/rides", WISH, headers=headers).json()
    again = campus.post("/rides", WISH, headers=headers)
    assert (again.status_code, again.json()["ride_id"]) == (201, first["ride_id"])
    other = campus.post("/rides", WISH | {"party": 1}, headers=headers)
    assert (other.status_code, other.json()["code"]) == (409, "idempotency_mismatch")


@pytest.mark.parametrize(
    ("changes", "status", "code", "names"),
    [
        ({"party": 7}, 409, "party_too_large", "6"),
        ({"to_stop": "the-moon"}, 404, "stop_unknown", "the-moon"),
        ({"to_stop": "NN20"}, 400, "same_stop", ""),
        ({"wheelchairs": 3}, 400, "party_invalid", ""),
        ({"earliest": "2027-09-01T08:00:00Z"}, 409, "booking_too_far_ahead", ""),
    ],
)
def test_a_booking_that_cannot_be_asked_for_says_why(
    campus: ServerUnderTest, changes: dict[str, object], status: int, code: str, names: str
) -> None:
    answer = campus.post("/rides", WISH | changes)
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert names in answer.json()["detail"]
    campus.sign_in()
    assert campus.get("/rides").json() == []


def test_a_booking_outside_hours_says_when_the_campus_opens(tmp_path: Path) -> None:
    hours = ServiceHours("Asia/Shanghai", tuple(Opening(day, 18 * 3600, 20 * 3600) for day in range(7)))
    server = ServerUnderTest(tmp_path, rules=FleetRules(hours=hours))
    answer = server.post("/rides", WISH)
    assert (answer.status_code, answer.json()["code"]) == (409, "no_service")
    assert "18:00" in answer.json()["detail"]
    server.close()


def test_without_a_shuttle_the_ride_is_refused_by_the_rule_that_binds(server: ServerUnderTest) -> None:
    ride = book(server)
    assert (ride["state"], ride["vehicle_id"], ride["promise"]) == ("refused", None, None)
    assert ride["reason"] == "no_vehicle_free"
    assert ride["reason_detail"]


def test_a_passenger_follows_the_ride_by_its_secret_and_others_by_its_code(campus: ServerUnderTest) -> None:
    ride = book(campus)
    assert campus.get(f"/rides/{ride['token']}").json()["boarding_code"] == ride["boarding_code"]
    code = str(ride["ride_code"])
    spoken = campus.get("/rides/lookup", params={"code": f"{code[:3]} {code[3:].lower()}"})
    assert spoken.json()["ride_id"] == ride["ride_id"]
    assert "token" not in spoken.json()
    assert "boarding_code" not in spoken.json()
    assert campus.get("/rides/AAAAAAAAAAAAAAAAAAAAAAAA").status_code == 404


def test_guessing_ride_codes_is_slowed_down(server: ServerUnderTest) -> None:
    tries = [server.get("/rides/lookup", params={"code": f"AAAA{n:02d}"}).status_code for n in range(21)]
    assert tries == [404] * 20 + [429]


def test_a_cancelled_ride_leaves_the_order_and_cannot_be_cancelled_twice(campus: ServerUnderTest) -> None:
    ride = book(campus)
    campus.elapse(0.5)
    cancelled = campus.post(f"/rides/{ride['token']}/cancel")
    assert (cancelled.status_code, cancelled.json()["state"]) == (200, "cancelled")
    campus.elapse(1.5)
    order = campus.vehicle.last(Order)  # type: ignore[attr-defined]
    assert [visit.board for visit in order.visits if visit.board] == []
    again = campus.post(f"/rides/{ride['token']}/cancel")
    assert (again.status_code, again.json()["code"]) == (409, "ride_ended")


def test_an_operator_can_cancel_and_list_rides_and_nobody_else(campus: ServerUnderTest) -> None:
    ride = book(campus)
    path = f"/rides/id/{ride['ride_id']}/cancel"
    assert campus.get("/rides").status_code == 401
    assert campus.post(path).status_code == 401
    headers = campus.sign_in()
    assert campus.post(path).status_code == 403
    assert campus.post(path, headers=headers).json()["state"] == "cancelled"
    listed = campus.get("/rides", params={"state": "cancelled"}).json()
    assert [item["ride_id"] for item in listed] == [ride["ride_id"]]
    assert campus.get("/rides", params={"state": "aboard"}).json() == []


def test_a_tap_goes_to_the_vehicle_and_waits_for_its_answer(campus: ServerUnderTest) -> None:
    ride = book(campus)
    tap = campus.post(f"/rides/{ride['token']}/board")
    assert (tap.status_code, tap.json()["state"]) == (202, "pending")
    campus.elapse(0.5)
    heard = [m.tap_id for m in campus.vehicle.heard if type(m).__name__ == "PassengerTap"]  # type: ignore[attr-defined]
    assert heard == [tap.json()["tap_id"]]
    asked = campus.get(f"/rides/{ride['token']}/taps/{tap.json()['tap_id']}")
    assert asked.json()["state"] == "pending"
    other = book(campus)
    assert campus.get(f"/rides/{other['token']}/taps/{tap.json()['tap_id']}").status_code == 404
    alight = campus.post(f"/rides/{ride['token']}/alight")
    assert (alight.status_code, alight.json()["code"]) == (409, "ride_not_aboard")


def test_a_call_for_help_is_on_top_of_the_incidents_with_its_words(campus: ServerUnderTest) -> None:
    ride = book(campus)
    called = campus.post(f"/rides/{ride['token']}/help", {"text": "车门打不开"})
    assert called.status_code == 201
    campus.sign_in()
    first = campus.get("/incidents").json()[0]
    assert (first["incident_id"], first["priority"]) == (called.json()["incident_id"], 0)
    assert "车门打不开" in first["cause"]
    assert first["ride_id"] == ride["ride_id"]


@pytest.mark.parametrize("moment", ["0001-01-01T00:00:00+14:00", "9999-12-31T23:59:59-14:00"])
def test_moments_at_the_ends_of_the_calendar_are_refused_as_what_they_are(
    server: ServerUnderTest, moment: str
) -> None:
    server.sign_in()
    listed = server.get("/rides", params={"before": moment})
    booked = server.post("/rides", {"from_stop": "NN20", "to_stop": "C6", "earliest": moment})
    assert [listed.status_code, booked.status_code] == [422, 422]
    assert "must lie between 1970 and 2999" in listed.text


def test_an_operator_erases_who_rode_and_a_ride_that_goes_on_is_refused(campus: ServerUnderTest) -> None:
    ride, headers = book(campus), campus.sign_in()
    path = f"/rides/id/{ride['ride_id']}/erase"
    early = campus.post(path, headers=headers)
    assert (early.status_code, early.json()["code"]) == (409, "ride_not_ended")
    campus.post(f"/rides/{ride['token']}/cancel")
    done = campus.post(path, headers=headers)
    assert (done.status_code, done.json()["ride_code"], done.json()["boarding_code"]) == (200, "", "")
    assert campus.get(f"/rides/{ride['token']}").status_code == 404
