"""Ranges of pickups and arrivals: never in the past, wider the less certain the plan is."""

from datetime import UTC, datetime, timedelta

import pytest

from server.domain.planning.eta_ranges import (
    ExpectedRange,
    PlannedArrival,
    PlannedPickup,
    PlannedRide,
    arrival_range,
    pickup_range,
    standing_of,
    waiting_arrival_range,
)

NOW = datetime(2026, 9, 1, 8, 0, 10, tzinfo=UTC)


def after(seconds: float) -> datetime:
    return NOW + timedelta(seconds=seconds)


def planned(eta_s: float, opens_s: float = -600.0, stops: int = 0) -> ExpectedRange:
    return pickup_range(NOW, PlannedPickup(after(eta_s), after(opens_s), stops))


def width_s(found: ExpectedRange) -> float:
    return (found.latest - found.earliest).total_seconds()


@pytest.mark.parametrize(
    ("eta_s", "opens_s", "standing"),
    [(300, 300, "early"), (300, 400, "early"), (300, 240, "on_time"), (300, 237, "behind")],
)
def test_a_plan_stands_early_on_time_or_behind(eta_s: float, opens_s: float, standing: str) -> None:
    assert standing_of(PlannedPickup(after(eta_s), after(opens_s), 0)) == standing


def test_the_planned_time_lies_inside_and_both_ends_are_round() -> None:
    for eta_s in (0, 45, 100, 200, 400, 800, 2000):
        found = planned(eta_s)
        assert found.earliest <= after(eta_s) <= found.latest
        assert found.latest.second % 30 == 0
        assert found.earliest == NOW or found.earliest.second % 30 == 0


def test_a_shuttle_that_waits_for_the_window_does_not_come_before_it_opens() -> None:
    found = planned(600, opens_s=590)
    assert found.earliest == after(590)
    assert planned(600, opens_s=-600).earliest < after(500)


def test_a_pickup_that_is_overdue_lies_ahead() -> None:
    found = planned(-120)
    assert found.earliest == NOW < found.latest


def test_more_stops_before_it_and_a_plan_behind_its_promise_make_it_less_certain() -> None:
    widths = [width_s(planned(400, opens_s=350, stops=stops)) for stops in (0, 1, 2, 3, 4)]
    assert widths[0] < widths[1] < widths[2] < widths[3] == widths[4]
    assert width_s(planned(400, opens_s=395)) < width_s(planned(400, opens_s=-100))


def test_far_ahead_it_is_wider_than_near() -> None:
    assert width_s(planned(100, opens_s=60)) < width_s(planned(1500, opens_s=1450))


def arriving(eta_s: float, stops: int = 0) -> ExpectedRange:
    return arrival_range(NOW, PlannedArrival(after(eta_s), stops))


def test_a_planned_arrival_lies_inside_and_both_ends_are_round() -> None:
    for eta_s in (0, 45, 100, 200, 400, 800, 2000):
        found = arriving(eta_s)
        assert NOW <= found.earliest <= after(eta_s) <= found.latest
        assert found.latest.second % 30 == 0
        assert found.earliest == NOW or found.earliest.second % 30 == 0


def test_on_a_free_road_the_party_may_arrive_much_earlier_than_planned() -> None:
    assert arriving(600).earliest <= after(350)
    assert arriving(600).latest <= after(650)


def test_an_arrival_after_other_stops_is_less_certain() -> None:
    widths = [width_s(arriving(600, stops)) for stops in (0, 1, 2, 3, 4)]
    assert widths[0] < widths[1] <= widths[2] <= widths[3] == widths[4]


def test_an_arrival_that_is_overdue_lies_ahead() -> None:
    assert arriving(-120).earliest == NOW < arriving(-120).latest


def waiting(pickup_s: float, ride_s: float, stops: int = 0) -> ExpectedRange:
    pickup = PlannedPickup(after(pickup_s), after(pickup_s), 0)
    return waiting_arrival_range(NOW, PlannedRide(pickup, after(pickup_s + ride_s), stops))


def test_the_arrival_of_a_party_that_waits_is_after_the_earliest_drive_and_before_the_planned_one() -> None:
    found = waiting(600.0, 600.0)
    assert after(1200.0) <= found.latest <= after(1230.0)
    assert found.earliest > after(300.0)
    assert all(end.second % 30 == 0 for end in (found.earliest, found.latest))


def test_the_arrival_is_less_certain_far_ahead_and_with_stops_on_the_way() -> None:
    assert width_s(waiting(60.0, 600.0)) < width_s(waiting(1800.0, 600.0))
    assert width_s(waiting(600.0, 600.0)) < width_s(waiting(600.0, 600.0, stops=2))


def test_an_arrival_of_a_party_that_waits_for_an_overdue_shuttle_lies_ahead() -> None:
    found = waiting(-300.0, 100.0)
    assert NOW <= found.earliest <= found.latest
