"""The timetable over REST: read, tried, saved by revision."""

import pytest

from tests.server.api.server_under_test import ServerUnderTest

TRIP = {
    "trip_id": "t1",
    "calls": [{"stop_id": "NN20", "leaves": "08:00"}, {"stop_id": "C6", "leaves": "24:30"}],
}


def put(
    server: ServerUnderTest, trips: list[object], revision: int, path: str = ""
) -> tuple[int, dict[str, object]]:
    headers = server.sign_in() | {"If-Match": str(revision)}
    method = "POST" if path else "PUT"
    answer = server.request(
        method, f"/service/trips{path}", json={"trips": trips, "note": "for term"}, headers=headers
    )
    return answer.status_code, answer.json()


def test_a_preview_changes_nothing_and_a_version_is_saved_once(server: ServerUnderTest) -> None:
    server.sign_in()
    before = server.get("/service/trips").json()
    assert (before["revision"], before["versions"]) == (0, [])
    status, effect = put(server, [TRIP], 0, "/previews")
    assert status == 200, effect
    assert effect["added"] == ["t1"]
    assert server.get("/service/trips").json() == before
    status, saved = put(server, [TRIP], 0)
    assert (status, saved["revision"], saved["made_by"]) == (200, 1, "operator")
    assert saved["trips"] == [TRIP | {"service_id": ""}]
    assert [trip["trip_id"] for trip in server.get("/timetable").json()["trips"]] == ["t1"]
    status, refused = put(server, [], 0)
    assert (status, refused["code"]) == (412, "timetable_changed")
    assert server.get("/service/trips/0").json()["trips"] == before["trips"]


@pytest.mark.parametrize(
    ("change", "status", "code"),
    [
        ({"calls": [{"stop_id": "NN20", "leaves": "08:00"}]}, 422, "payload_invalid"),
        ({"calls": [{"stop_id": "NN20", "leaves": "8 am"}] * 2}, 422, "payload_invalid"),
        ({"calls": [{"stop_id": "NN20", "leaves": "08:00"}] * 2}, 400, "timetable_invalid"),
        ({"service_id": "night"}, 400, "timetable_invalid"),
    ],
)
def test_a_trip_that_cannot_run_is_refused(
    server: ServerUnderTest, change: dict[str, object], status: int, code: str
) -> None:
    answered, problem = put(server, [TRIP | change], 0)
    assert (answered, problem["code"]) == (status, code)
