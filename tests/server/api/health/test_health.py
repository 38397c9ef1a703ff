"""What the server says about itself: ready only if all that it needs works."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from server.domain.errors import StoreUnavailable
from server.supervision.retries import RetryPolicy
from server.supervision.standing_tasks import PeriodicTask
from tests.server.api.server_under_test import ServerUnderTest

ENDURING = RetryPolicy(first_s=1.0, pause_s_max=1.0, jitter_ratio=0.0, failures_max=1000)


class SickTask:
    """Fails as long as it is sick."""

    def __init__(self) -> None:
        self.is_sick = True

    async def work(self) -> None:
        if self.is_sick:
            raise OSError("disk full")


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerUnderTest]:
    server = ServerUnderTest(tmp_path, retry=ENDURING, disk_free_bytes_min=0)
    yield server
    server.close()


@pytest.fixture
def sick(server: ServerUnderTest) -> SickTask:
    sick = SickTask()

    async def start() -> None:
        server.services.supervisor.start(PeriodicTask("dispatcher", sick.work, 1.0))

    server.run(start())
    return sick


def degraded(server: ServerUnderTest) -> list[str]:
    server.sign_in()
    incidents = server.get("/incidents").json()
    return [incident["cause"] for incident in incidents if incident["kind"] == "server_degraded"]


def test_a_server_whose_parts_all_work_is_ready_and_names_them(server: ServerUnderTest) -> None:
    server.elapse(3.0)
    answer = server.get("/ready")
    assert answer.status_code == 200
    ready = answer.json()
    assert (ready["ready"], ready["database"], ready["disk_has_room"]) == (True, "good", True)
    states = {task["name"]: task["state"] for task in ready["tasks"]}
    assert states.keys() >= {"hub.record", "hub.outbox", "feed.refresh", "outages"}
    assert set(states.values()) == {"good"}


def test_a_server_with_a_failing_task_is_not_ready_and_says_which(
    server: ServerUnderTest, sick: SickTask
) -> None:
    server.elapse(2.0)
    answer = server.get("/ready")
    assert answer.status_code == 503
    failing = [task for task in answer.json()["tasks"] if task["state"] != "good"]
    assert [(task["name"], task["state"], task["last_good_at"]) for task in failing] == [
        ("dispatcher", "failing", None)
    ]
    sick.is_sick = False
    server.elapse(2.0)
    assert server.get("/ready").status_code == 200


def test_an_incident_says_what_is_degraded_since_when_and_closes_by_itself(
    server: ServerUnderTest, sick: SickTask
) -> None:
    server.elapse(5.0)
    assert degraded(server) == ["dispatcher has failed since 08:00:00 UTC: OSError: disk full"]
    sick.is_sick = False
    server.elapse(4.0)
    assert degraded(server) == []


def test_an_outage_that_ended_before_it_could_be_recorded_is_in_the_record_afterwards(
    server: ServerUnderTest, sick: SickTask
) -> None:
    server.elapse(1.5)
    assert server.services.supervisor.present_outages() != ()
    sick.is_sick = False
    server.elapse(4.0)
    server.sign_in()
    incidents = server.get("/incidents?closed=true").json()
    assert [(incident["kind"], incident["closed_by"]) for incident in incidents] == [
        ("server_degraded", "server")
    ]


def test_a_server_whose_database_does_not_answer_is_not_ready(
    server: ServerUnderTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def lost(work: object) -> None:
        raise StoreUnavailable("out of reach")

    with monkeypatch.context() as outage:
        outage.setattr(server.transactions, "read", lost)
        answer = server.get("/ready")
        assert (answer.status_code, answer.json()["database"]) == (503, "unavailable")
    assert server.get("/ready").status_code == 200


def test_a_server_without_room_on_its_disk_is_not_ready(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, disk_free_bytes_min=2**62)
    answer = server.get("/ready")
    assert (answer.status_code, answer.json()["disk_has_room"]) == (503, False)
    server.close()


def test_a_server_that_stops_says_that_it_leaves(server: ServerUnderTest) -> None:
    assert server.get("/ready").json()["leaving"] is False
    server.run(server.services.hub.leave())
    answer = server.get("/ready")
    assert (answer.status_code, answer.json()["leaving"]) == (503, True)
