"""One ride as operators see it: its history, whom it delays, and a booking for a caller."""

import httpx
import pytest

from tests.server.api.rides.test_rides import WISH, book
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.test_hub import at_rest
from tests.server.fleet.vehicle_key import VehicleKeyPair


@pytest.fixture
def campus(server: ServerUnderTest) -> ServerUnderTest:
    """With one shuttle that stands ready, and an operator who has signed in."""
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    server.vehicle = SpokenVehicle(server).dial().hello()  # type: ignore[attr-defined]
    at_rest(server, server.vehicle)  # type: ignore[attr-defined]
    server.headers = server.sign_in()  # type: ignore[attr-defined]
    return server


def ask(campus: ServerUnderTest, path: str, body: object = None) -> httpx.Response:
    """As the operator."""
    return campus.post(path, body, headers=campus.headers)  # type: ignore[attr-defined]


def test_the_history_of_a_ride_tells_what_happened_in_its_order(campus: ServerUnderTest) -> None:
    ride = book(campus)
    campus.post(f"/rides/{ride['token']}/help", {"text": "my knee hurts"})
    campus.post(f"/rides/{ride['token']}/cancel")
    history = campus.get(f"/rides/id/{ride['ride_id']}/history").json()
    assert [event["name"] for event in history] == ["ride.booked", "ride.help_called", "ride.cancelled"]
    assert history[1]["detail"] == "my knee hurts"
    assert [event["by"] for event in history] == ["passenger"] * 3


def test_rides_are_found_by_code_stop_and_time(campus: ServerUnderTest) -> None:
    first, second = book(campus), book(campus, from_stop="C6", to_stop="NN7")

    def found(query: str) -> list[str]:
        answer = campus.get(f"/rides?{query}")
        assert answer.status_code == 200, answer.text
        return [ride["ride_id"] for ride in answer.json()]

    code = str(first["ride_code"])
    assert found(f"code={code[:3].lower()}%20{code[3:]}") == [first["ride_id"]]
    assert found("stop_id=NN7") == [second["ride_id"]]
    assert set(found("stop_id=C6")) == {first["ride_id"], second["ride_id"]}
    assert found("since=2999-01-01T00:00:00Z") == []
    assert len(found("since=2000-01-01T00:00:00Z&vehicle_id=shuttle-1")) == 2


def test_whom_a_ride_delays_is_told_and_nothing_changes(campus: ServerUnderTest) -> None:
    first = book(campus)
    # On the way of the first one, who rides longer because of it.
    second = book(campus, from_stop="NN20", to_stop="NN7")
    before = campus.get(f"/rides/id/{first['ride_id']}").json()
    answer = ask(campus, f"/rides/id/{second['ride_id']}/delays")
    assert answer.status_code == 200, answer.text
    delayed = answer.json()
    assert {one["ride_id"] for one in delayed} <= {first["ride_id"]}
    assert all(one["arrival_s"] >= 1.0 or one["pickup_s"] >= 1.0 for one in delayed)
    assert campus.get(f"/rides/id/{first['ride_id']}").json() == before
    assert campus.get(f"/rides/id/{second['ride_id']}").json()["state"] == "assigned"


def test_a_ride_that_has_ended_delays_nobody(campus: ServerUnderTest) -> None:
    ride = book(campus)
    campus.post(f"/rides/{ride['token']}/cancel")
    answer = ask(campus, f"/rides/id/{ride['ride_id']}/delays")
    assert (answer.status_code, answer.json()["code"]) == (409, "ride_not_assigned")


def test_an_operator_books_for_a_caller_and_tells_the_codes(campus: ServerUnderTest) -> None:
    answer = ask(campus, "/rides/for-caller", WISH)
    assert answer.status_code == 201, answer.text
    booked = answer.json()
    assert (booked["ride"]["state"], booked["ride"]["source"]) == ("assigned", "operator")
    assert len(booked["ride"]["boarding_code"]) == 4
    assert booked["alternatives"] == []
    assert "token" not in booked["ride"]


def test_a_caller_who_cannot_be_served_is_offered_what_could_be(campus: ServerUnderTest) -> None:
    answer = ask(campus, "/rides/for-caller", WISH | {"party": 6, "wheelchairs": 3})
    assert answer.status_code == 201, answer.text
    assert answer.json()["ride"]["state"] == "refused"
    assert answer.json()["ride"]["reason"] != ""
    assert ask(campus, "/rides/for-caller", WISH | {"to_stop": "NN20"}).json()["code"] == "same_stop"
