"""Figures over REST."""

import msgspec

from server.domain.record.statistics import DrivingFigures, ServiceFigures
from tests.server.api.replays.test_replays import FROM_MS, drove
from tests.server.api.server_under_test import ServerUnderTest


def test_only_who_may_read_the_console_sees_figures(server: ServerUnderTest) -> None:
    for path in ("/statistics/service", "/statistics/driving"):
        assert server.get(path, params={"from_ms": FROM_MS}).status_code == 401


def test_a_fleet_that_drove_has_speeds_and_a_distance(server: ServerUnderTest) -> None:
    drove(server, 100)
    server.sign_in()
    answer = server.get("/statistics/driving", params={"from_ms": FROM_MS})
    figures = msgspec.json.decode(answer.content, type=DrivingFigures)
    # 100 positions at 1.5 m/s, each for half a second.
    assert [(one.from_kmh, one.positions) for one in figures.speeds] == [(5, 100)]
    assert figures.distance_m == 75.0
    assert (figures.brakings, figures.takeovers, figures.minimal_risk_stops) == (0, 0, 0)


def test_a_week_without_rides_has_24_empty_hours(server: ServerUnderTest) -> None:
    server.sign_in()
    answer = server.get("/statistics/service", params={"from_ms": FROM_MS})
    figures = msgspec.json.decode(answer.content, type=ServiceFigures)
    assert len(figures.hours) == 24
    assert figures.waiting_s.count == 0


def test_a_stretch_that_is_too_long_is_refused(server: ServerUnderTest) -> None:
    server.sign_in()
    for path in ("/statistics/service", "/statistics/driving"):
        wrong = {"from_ms": FROM_MS, "seconds": 10**8}
        assert server.get(path, params=wrong).status_code == 422
