"""Notes on incidents and the shift log: in order, in the operator's name, and for operators alone."""

from server.domain.record.incidents import IncidentKind
from server.usecases.record.incidents import open_incident
from tests.server.api.server_under_test import ServerUnderTest


def an_incident(server: ServerUnderTest) -> str:
    incident = server.transact(
        lambda uow: open_incident(uow, IncidentKind.SERVER_DEGRADED, "disk", "the disk is full")
    )
    return str(incident.incident_id)


def test_a_note_stands_in_order_among_what_happened(server: ServerUnderTest) -> None:
    headers, incident_id = server.sign_in(), an_incident(server)
    path = f"/incidents/{incident_id}"
    assert server.post(f"{path}/notes", {"text": "calling the janitor"}, headers=headers).status_code == 201
    server.post(f"{path}/close", headers=headers)
    assert server.post(f"{path}/notes", {"text": "it was the log"}, headers=headers).status_code == 201
    history = server.get(f"{path}/history").json()
    assert [event["name"] for event in history] == [
        "incident.opened",
        "incident.noted",
        "incident.closed",
        "incident.noted",
    ]
    assert history[1]["text"] == "calling the janitor"
    assert history[1]["by"] == history[2]["by"] != ""


def test_the_shift_log_has_its_latest_entries_oldest_first(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    for number in range(3):
        assert server.post("/shift-log", {"text": f"entry {number}"}, headers=headers).status_code == 201
    assert [one["text"] for one in server.get("/shift-log?limit=2").json()] == ["entry 1", "entry 2"]


def test_a_repeat_with_the_same_key_is_written_once(server: ServerUnderTest) -> None:
    headers = server.sign_in() | {"Idempotency-Key": "6f1d0c1e-2b7a-4f0e-9a34-0d5c2f7be801"}
    for _ in range(2):
        server.post("/shift-log", {"text": "keys are in the drawer"}, headers=headers)
    assert len(server.get("/shift-log").json()) == 1


def test_empty_notes_unknown_incidents_and_strangers_are_refused(server: ServerUnderTest) -> None:
    incident_id = an_incident(server)
    assert server.get("/shift-log").status_code == 401
    assert server.get(f"/incidents/{incident_id}/history").status_code == 401
    headers = server.sign_in()
    assert server.post("/shift-log", {"text": "  "}, headers=headers).status_code == 422
    assert server.post("/incidents/incident-x/notes", {"text": "a"}, headers=headers).status_code == 404
    assert server.post("/shift-log", {"text": "a"}).status_code == 403


def test_notes_are_erased_with_the_rider_whom_they_are_about(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    ride = server.post("/rides", {"from_stop": "NN20", "to_stop": "C6", "party": 1}).json()
    called = server.post(f"/rides/{ride['token']}/help", {"text": "my knee hurts"}).json()
    path = f"/incidents/{called['incident_id']}"
    server.post(f"{path}/notes", {"text": "she is 80 and waits at C6"}, headers=headers)
    assert "80" in server.get(f"{path}/history").text
    if server.get(f"/rides/id/{ride['ride_id']}").json()["state"] != "refused":
        server.post(f"/rides/{ride['token']}/cancel")
    assert server.post(f"/rides/id/{ride['ride_id']}/erase", headers=headers).status_code == 200
    history = server.get(f"{path}/history").json()
    assert [event["name"] for event in history][:2] == ["incident.opened", "incident.noted"]
    assert {event["text"] for event in history} == {""}
