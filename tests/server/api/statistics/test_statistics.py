"""Figures over REST."""

import msgspec
import pytest

from contract.wire.messages import ModeChanged
from server.api.statistics import routes
from server.domain.instants import ns_of
from server.domain.record.events import RecordedEvent
from server.domain.record.statistics import DrivingFigures, ServiceFigures
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.api.replays.test_replays import FROM_MS, drove
from tests.server.api.server_under_test import START, ServerUnderTest


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


def test_who_counts_no_more_events_says_so(server: ServerUnderTest, monkeypatch: pytest.MonkeyPatch) -> None:
    drove(server, 1)

    def take_over(uow: UnitOfWork) -> None:
        for k in range(3):
            at_ns = ns_of(START) + k
            uow.events.add(RecordedEvent("shuttle-1", "boot-1", k, at_ns, at_ns, ModeChanged("manual")))

    server.transact(take_over)
    server.sign_in()
    for events_max, is_cut in ((4, False), (3, False), (2, True)):
        monkeypatch.setattr(routes, "EVENTS_MAX", events_max)
        answer = server.get("/statistics/driving", params={"from_ms": FROM_MS})
        figures = msgspec.json.decode(answer.content, type=DrivingFigures)
        assert figures.takeovers == min(3, events_max)
        assert figures.is_cut == is_cut


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
