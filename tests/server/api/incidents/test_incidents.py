from server.domain.record.incidents import IncidentKind
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import incidents
from tests.server.api.server_under_test import ServerUnderTest


def open_incident(server: ServerUnderTest, kind: IncidentKind, subject: str) -> str:
    def work(uow: UnitOfWork) -> str:
        return incidents.open_incident(uow, kind, subject, f"cause of {subject}").incident_id

    incident_id: str = server.transact(work)
    return incident_id


def test_a_call_for_help_stands_above_everything(server: ServerUnderTest) -> None:
    open_incident(server, IncidentKind.SEAT_BUTTON, "a")
    open_incident(server, IncidentKind.VEHICLE_BLOCKED, "b")
    open_incident(server, IncidentKind.HELP_CALL, "c")
    server.sign_in()
    assert [item["kind"] for item in server.get("/incidents").json()] == [
        "help_call",
        "vehicle_blocked",
        "seat_button",
    ]


def test_incidents_are_acknowledged_and_closed_by_name(server: ServerUnderTest) -> None:
    incident_id = open_incident(server, IncidentKind.TAKEOVER, "shuttle-1")
    headers = server.sign_in()
    taken = server.post(f"/incidents/{incident_id}/acknowledge", headers=headers).json()
    assert (taken["acknowledged_by"], taken["closed_at"]) == ("operator", None)
    assert server.post(f"/incidents/{incident_id}/close", headers=headers).json()["closed_by"] == "operator"
    again = server.post(f"/incidents/{incident_id}/close", headers=headers)
    assert (again.status_code, again.json()["code"]) == (409, "incident_closed")
    assert server.get("/incidents").json() == []
    assert [item["incident_id"] for item in server.get("/incidents?closed=true").json()] == [incident_id]


def test_an_unknown_incident_is_a_404_and_strangers_see_none(server: ServerUnderTest) -> None:
    assert server.get("/incidents").status_code == 401
    headers = server.sign_in()
    assert server.post("/incidents/incident-99/close", headers=headers).status_code == 404
