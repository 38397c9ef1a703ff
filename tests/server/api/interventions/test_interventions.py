"""Previews and reassignments over REST."""

import pytest

from server.domain.errors import NoRestingPlaceFree
from server.usecases.planning import plans
from tests.server.api.rides.test_rides import book, campus
from tests.server.api.server_under_test import ServerUnderTest

__all__ = ["campus"]


def test_a_preview_tells_whom_it_concerns_and_changes_nothing(campus: ServerUnderTest) -> None:
    ride = book(campus)
    headers = campus.sign_in()
    before = campus.get("/vehicles/shuttle-1").json()
    answer = campus.post("/vehicles/shuttle-1/previews", {"kind": "hold", "for_s": 600.0}, headers=headers)
    assert answer.status_code == 200, answer.text
    (effect,) = answer.json()["rides"]
    assert (effect["ride_code"], effect["vehicle_after"]) == (ride["ride_code"], "shuttle-1")
    assert effect["arrival_later_s"] == pytest.approx(600.0, abs=5.0)
    assert effect["breaks"]
    until_resumed = campus.post("/vehicles/shuttle-1/previews", {"kind": "hold"}, headers=headers).json()
    assert [e["waits"] for e in until_resumed["rides"]] == [True]
    recalled = campus.post("/vehicles/shuttle-1/previews", {"kind": "recall"}, headers=headers).json()
    assert [e["vehicle_after"] for e in recalled["rides"]] == [None]
    after = campus.get("/vehicles/shuttle-1").json()
    for key in ("held", "in_service", "plan_version", "hold_ends"):
        assert after[key] == before[key], key


def test_a_hold_for_a_while_is_taken_over_and_ends(campus: ServerUnderTest) -> None:
    headers = campus.sign_in()
    held = campus.post("/vehicles/shuttle-1/hold", headers=headers, params={"for_s": 60.0})
    assert (held.status_code, held.json()["kind"]) == (202, "hold")
    facts = campus.get("/vehicles/shuttle-1").json()
    assert facts["held"]
    assert facts["hold_ends"] is not None


def test_a_hold_reaches_the_shuttle_even_when_its_rides_cannot_be_planned(
    campus: ServerUnderTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nowhere(*_: object) -> None:
        raise NoRestingPlaceFree("every resting place belongs to another shuttle")

    headers = campus.sign_in()
    monkeypatch.setattr(plans, "replan", nowhere)
    held = campus.post("/vehicles/shuttle-1/hold", headers=headers)
    assert (held.status_code, held.json()["kind"]) == (202, "hold")


def test_a_reassignment_that_nobody_can_take_names_the_rule(campus: ServerUnderTest) -> None:
    ride = book(campus)
    headers = campus.sign_in()
    every = campus.post("/vehicles/shuttle-1/reassign", {}, headers=headers)
    assert (every.status_code, every.json()) == (200, {"rides": [], "departures": []})
    one = campus.post("/vehicles/shuttle-1/reassign", {"ride_id": ride["ride_id"]}, headers=headers)
    assert (one.status_code, one.json()["code"]) == (409, "reassignment_refused")
    assert one.json()["rule"] == "no_vehicle_free"


@pytest.mark.parametrize(
    ("body", "status", "code"),
    [
        ({"kind": "explode"}, 422, "unprocessable_entity"),
        ({"kind": "hold", "for_s": 1.0}, 422, ""),
        ({"kind": "hold", "for_s": 1e9}, 422, ""),
        ({"kind": "reassign", "ride_id": "nobody"}, 404, "ride_unknown"),
        ({"kind": "recall", "surprise": 1}, 422, ""),
    ],
)
def test_wishes_that_cannot_be_are_refused(
    campus: ServerUnderTest, body: dict[str, object], status: int, code: str
) -> None:
    answer = campus.post("/vehicles/shuttle-1/previews", body, headers=campus.sign_in())
    assert answer.status_code == status, answer.text
    if status != 422:
        assert answer.json()["code"] == code


def test_only_operators_may_look(campus: ServerUnderTest) -> None:
    assert campus.post("/vehicles/shuttle-1/previews", {"kind": "recall"}).status_code in (401, 403)
    missing = campus.post("/vehicles/ghost/previews", {"kind": "recall"}, headers=campus.sign_in())
    assert (missing.status_code, missing.json()["code"]) == (404, "vehicle_unknown")
