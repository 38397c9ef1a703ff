"""What Prometheus reads, and what it must never read."""

from pathlib import Path

from prometheus_client.parser import text_string_to_metric_families

from server.usecases.record import identity
from tests.server.api.server_under_test import ServerUnderTest

Samples = dict[tuple[str, frozenset[tuple[str, str]]], float]


def samples(server: ServerUnderTest) -> Samples:
    server.sign_in()
    answer = server.get("/metrics")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/plain")
    return {
        (sample.name, frozenset(sample.labels.items())): sample.value
        for family in text_string_to_metric_families(answer.text)
        for sample in family.samples
    }


def test_standing_tasks_and_vehicles_are_counted(server: ServerUnderTest) -> None:
    server.elapse(3.0)
    found = samples(server)
    assert found["campusloop_vehicles_connected", frozenset()] == 0.0
    record = frozenset({("task", "hub.record")})
    assert found["campusloop_task_works", record] == 1.0
    assert found["campusloop_task_failures_total", record] == 0.0
    last_good_s = found["campusloop_task_last_good_timestamp_seconds", record]
    assert server.clock.now().timestamp() - last_good_s < 2.0


def test_requests_are_counted_by_the_template_of_their_route(server: ServerUnderTest) -> None:
    ride = server.post("/rides", {"from_stop": "NN20", "to_stop": "C6"}).json()
    for _ in range(3):
        server.get(f"/rides/{ride['token']}")
    labels = {"method": "GET", "route": "/rides/{token}", "status": "200"}
    found = samples(server)
    assert found["campusloop_http_request_duration_seconds_count", frozenset(labels.items())] == 3.0


def test_no_secret_and_no_word_of_a_client_is_a_label(server: ServerUnderTest) -> None:
    ride = server.post("/rides", {"from_stop": "NN20", "to_stop": "C6"}).json()
    server.get(f"/rides/{ride['token']}")
    server.get(f"/no-such-thing/{ride['token']}")
    server.request("INVENTED", "/rides")
    server.sign_in()
    text = server.get("/metrics").text
    assert ride["token"] not in text
    assert "INVENTED" not in text
    assert 'method="other"' in text


def test_prometheus_reads_with_the_token_of_the_settings_and_nothing_else(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, metrics_token="measure")
    prometheus = {"Authorization": "Bearer measure"}
    assert server.get("/metrics", headers=prometheus).status_code == 200
    assert server.get("/metrics", headers={"Authorization": "Bearer measures"}).status_code == 401
    assert server.get("/vehicles", headers=prometheus).status_code == 401
    server.close()


def test_measurements_are_for_readers_only(server: ServerUnderTest) -> None:
    assert server.get("/metrics").status_code == 401
    created = server.transact(
        lambda uow: identity.create_developer_token(uow, "prometheus", ["read"], 3600.0, "operator")
    )
    answer = server.get("/metrics", headers={"Authorization": f"Bearer {created.secret}"})
    assert answer.status_code == 200
