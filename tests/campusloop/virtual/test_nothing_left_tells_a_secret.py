"""A morning of a whole campus: nothing that it leaves behind holds a secret that was handed out."""

from pathlib import Path
from typing import Any

import pytest

from campusloop.clients.passengers import Journey, RideDemand
from campusloop.virtual.campus import OPERATOR, CampusOptions, VirtualCampus
from tests.campusloop.secret_search import Secrets
from tests.contract.roads.ring_map import ring_map
from tests.faults.real_campus import nearest_pair

KINDS = {
    "token",
    "boarding_code",
    "csrf_token",
    "secret",
    "enrolment code",
    "idempotency key",
    "password",
    "cookie campusloop_session",
}


class Morning:
    """One passenger who boards by code, and others who get the remaining kinds of secrets."""

    def __init__(self, folder: Path) -> None:
        self.secrets = Secrets()
        road_map = ring_map()
        options = CampusOptions(
            road_map,
            folder,
            vehicles=1,
            traffic=None,
            database_url=f"sqlite:///{folder / 'campus.db'}",
        )
        self.campus = VirtualCampus(options)
        self.secrets.listen(self.campus.client)
        self.secrets.add("password", OPERATOR[1])
        self.stops = nearest_pair(road_map)

    def live_through(self) -> Journey:
        self.campus.start()
        journey = Journey(RideDemand(1, 0.0, *self.stops, 1, "code"))
        passengers = self.campus.passengers(lambda _: None)
        self.campus.conductor.loop.create_task(passengers.run_journey(journey))
        series = {
            "from_stop": self.stops[0],
            "to_stop": self.stops[1],
            "weekdays": [0, 1, 2, 3, 4, 5, 6],
            "leave": "12:00",
            "ends_on": "2026-09-03",
        }
        made = self.post("/series", series, key="the key of a recurring booking")
        ride = {"from_stop": self.stops[1], "to_stop": self.stops[0]}
        ticket = self.post("/rides", ride, key="the-key-of-a-booking")
        self.post(f"/rides/{ticket['token']}/help", {"text": "Hello?"}, key="the-key-of-a-call-for-help")
        self.post(f"/rides/{ticket['token']}/cancel", None, key="the-key-of-a-cancellation")
        self.post("/developer-tokens", {"name": "script", "scopes": ["read", "drive"]})
        assert self.campus.conductor.run_until(lambda: journey.state == "aboard", 600.0)
        self.campus.call(self.campus.client.get(f"/api/v1/series/{made['token']}"))
        self.campus.stop()
        return journey

    def post(self, path: str, body: object, key: str = "") -> dict[str, Any]:
        headers = {"X-CSRF-Token": self.campus.operator._csrf}
        if key:
            headers["Idempotency-Key"] = key.replace(" ", "-")
        client = self.campus.client
        answer = self.campus.call(client.post(f"/api/v1{path}", json=body, headers=headers))
        assert answer.is_success, answer.text
        found: dict[str, Any] = answer.json()
        return found


@pytest.mark.long
def test_databases_run_logs_disks_of_vehicles_and_journals_hold_no_secret(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    morning = Morning(tmp_path)
    journey = morning.live_through()
    assert [state for _, state in journey.history][-1] == "aboard", "nobody has boarded by code"
    assert morning.secrets.kinds() >= KINDS
    found = morning.secrets.found_in_folder(tmp_path)
    journal = "".join(capfd.readouterr())
    assert "server.started" in journal
    assert found | morning.secrets.found_in("journal", journal.encode()) == set()
    assert list(tmp_path.rglob("*.mcap")), "there is no run log"
