from pathlib import Path

from server.domain.rules import FleetRules
from server.domain.service.timetable import Opening, ServiceHours
from tests.server.api.server_under_test import ServerUnderTest, snow_lion


def test_the_campus_says_where_it_lies_and_when_it_runs(server: ServerUnderTest) -> None:
    campus = server.get("/campus").json()
    assert campus["campus_id"] == "snow-lion"
    assert campus["schematic"] is True
    assert campus["timezone"] == "Asia/Shanghai"
    assert campus["open_now"] is True
    assert campus["map_version"] == snow_lion().map_version


def test_a_closed_campus_says_when_it_opens(tmp_path: Path) -> None:
    hours = ServiceHours("Asia/Shanghai", tuple(Opening(day, 18 * 3600, 20 * 3600) for day in range(7)))
    server = ServerUnderTest(tmp_path, rules=FleetRules(hours=hours))
    campus = server.get("/campus").json()
    assert campus["open_now"] is False
    assert campus["opens_next"] == "2026-09-01T10:00:00Z"
    server.close()


def test_every_stop_of_the_map_is_listed_in_order(server: ServerUnderTest) -> None:
    stops = server.get("/stops").json()
    assert [stop["stop_id"] for stop in stops] == [stop.stop_id for stop in snow_lion().stops]


def test_the_drawing_of_the_map_has_every_lane_and_is_sent_once(server: ServerUnderTest) -> None:
    answer = server.get("/campus/map")
    drawing = answer.json()
    assert {lane["lane_id"] for lane in drawing["lanes"]} == {lane.lane_id for lane in snow_lion().lanes}
    x_min, y_min, x_max, y_max = drawing["bounds"]
    for lane in drawing["lanes"]:
        xs, ys = lane["xy"][0::2], lane["xy"][1::2]
        assert len(xs) == len(ys) >= 2
        assert x_min - 0.01 <= min(xs) <= max(xs) <= x_max + 0.01
        assert y_min - 0.01 <= min(ys) <= max(ys) <= y_max + 0.01
    again = server.get("/campus/map", headers={"If-None-Match": answer.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_without_a_map_the_server_lives_but_is_not_ready(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, with_map=False)
    assert server.get("/health").json() == {"status": "ok"}
    assert server.get("/ready").status_code == 503
    for path in ("/campus", "/stops", "/campus/map"):
        problem = server.get(path)
        assert (problem.status_code, problem.json()["code"]) == (404, "campus_unknown")
        assert "import" in problem.json()["detail"]
    server.close()


def test_with_a_map_the_server_is_ready(server: ServerUnderTest) -> None:
    ready = server.get("/ready")
    assert (ready.status_code, ready.json()["vehicles_connected"]) == (200, 0)


def test_the_stops_come_compressed_and_in_pages_with_their_link(server: ServerUnderTest) -> None:
    plain = server.get("/stops", headers={"Accept-Encoding": "identity"})
    packed = server.get("/stops", headers={"Accept-Encoding": "gzip"})
    assert packed.headers["Content-Encoding"] == "gzip"
    assert packed.json() == plain.json()
    assert packed.headers["ETag"] != plain.headers["ETag"]
    (first,) = server.get("/stops?limit=1").json()
    assert first == plain.json()[0]
    assert 'rel="next"' in server.get("/stops?limit=1").headers["Link"]
