"""What an operator is shown of an intervention before it is made."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest

from server.domain.rides.effects import DepartureEffect, RideEffect, ride_effect
from server.domain.rides.rides import Promise, Ride, RideState

NOW = datetime(2026, 11, 23, 8, 0, tzinfo=UTC)
ROOM_S = 20.0


def minutes(count: float) -> datetime:
    return NOW + timedelta(minutes=count)


PROMISE = Promise(minutes(5), minutes(10), minutes(20))
BEFORE = Ride(
    campus_id="campus",
    ride_id="ride-1",
    ride_code="ACDEFG",
    ticket_key_id="key",
    state=RideState.ASSIGNED,
    from_stop="a",
    to_stop="b",
    party=2,
    wheelchairs=0,
    earliest=NOW,
    requested_at=NOW,
    source="passenger",
    promise=PROMISE,
    vehicle_id="shuttle-1",
    pickup_eta=minutes(6),
    arrival_eta=minutes(15),
)
ABOARD = replace(BEFORE, state=RideState.ABOARD)


def effect(before: Ride = BEFORE, waits: bool = False, **changes: object) -> RideEffect | None:
    return ride_effect(before, replace(before, **changes), ROOM_S, waits=waits)  # type: ignore[arg-type]


def shown(before: Ride = BEFORE, waits: bool = False, **changes: object) -> RideEffect:
    found = effect(before, waits, **changes)
    assert found is not None
    return found


def test_a_ride_that_goes_on_as_before_is_not_shown() -> None:
    assert effect() is None
    assert effect(ABOARD) is None
    assert effect(arrival_eta=minutes(15) + timedelta(seconds=0.9)) is None


@pytest.mark.parametrize("moved_s", [1.0, -1.0])
def test_times_that_move_by_a_second_are_shown(moved_s: float) -> None:
    later = shown(pickup_eta=minutes(6) + timedelta(seconds=moved_s))
    assert (later.pickup_later_s, later.arrival_later_s, later.breaks) == (moved_s, 0.0, False)
    assert shown(arrival_eta=minutes(15) + timedelta(seconds=moved_s)).arrival_later_s == moved_s


def test_a_ride_that_changes_its_shuttle_names_both() -> None:
    moved = shown(vehicle_id="shuttle-2")
    assert (moved.vehicle_before, moved.vehicle_after) == ("shuttle-1", "shuttle-2")


def test_a_ride_that_fails_is_left_with_nobody() -> None:
    failed = shown(state=RideState.FAILED)
    assert (failed.state, failed.vehicle_before, failed.vehicle_after) == (
        RideState.FAILED,
        "shuttle-1",
        None,
    )


def test_of_a_party_aboard_only_the_arrival_is_shown() -> None:
    late = shown(ABOARD, arrival_eta=minutes(18))
    assert (late.pickup_before, late.pickup_after, late.pickup_later_s) == (None, None, None)
    assert late.arrival_later_s == 180.0


def test_who_waits_in_a_shuttle_that_stands_has_no_times() -> None:
    stands = shown(waits=True)
    assert (stands.waits, stands.pickup_after, stands.arrival_after) == (True, None, None)
    assert (stands.pickup_before, stands.arrival_before) == (minutes(6), minutes(15))
    assert (stands.pickup_later_s, stands.arrival_later_s) == (None, None)


@pytest.mark.parametrize(("late_s", "breaks"), [(ROOM_S, False), (ROOM_S + 1.0, True)])
def test_a_promise_breaks_when_the_plan_misses_it_by_more_than_its_room(late_s: float, breaks: bool) -> None:
    late = timedelta(seconds=late_s)
    assert shown(pickup_eta=PROMISE.pickup_to + late).breaks is breaks
    assert shown(arrival_eta=PROMISE.arrive_by + late).breaks is breaks
    assert shown(ABOARD, arrival_eta=PROMISE.arrive_by + late).breaks is breaks


def test_a_late_pickup_breaks_nothing_for_who_is_aboard() -> None:
    assert not shown(ABOARD, pickup_eta=minutes(30), arrival_eta=minutes(16)).breaks


def test_a_promise_that_was_missed_already_or_never_made_does_not_break() -> None:
    late = replace(BEFORE, pickup_eta=minutes(12))
    assert not shown(late, pickup_eta=minutes(14)).breaks
    assert not shown(replace(BEFORE, promise=None), pickup_eta=minutes(60)).breaks


def test_the_promise_that_counts_is_the_one_from_before() -> None:
    told_anew = Promise(minutes(30), minutes(40), minutes(60))
    moved = shown(pickup_eta=minutes(35), arrival_eta=minutes(50), promise=told_anew, promise_broken=True)
    assert moved.breaks


@pytest.mark.parametrize(
    ("vehicle_after", "late_before_s", "late_after_s", "waits", "news"),
    [
        ("shuttle-1", 30.0, 30.0, False, False),
        ("shuttle-1", 30.0, 30.9, False, False),
        ("shuttle-1", 30.0, 31.0, False, True),
        ("shuttle-1", 31.0, 30.0, False, True),
        ("shuttle-2", 0.0, 0.0, False, True),
        (None, 0.0, 0.0, False, True),
        ("shuttle-1", 0.0, 0.0, True, True),
    ],
)
def test_of_a_departure_its_vehicle_its_lateness_and_its_standing_are_news(
    vehicle_after: str | None, late_before_s: float, late_after_s: float, waits: bool, news: bool
) -> None:
    shown = DepartureEffect("first", "shuttle-1", vehicle_after, late_before_s, late_after_s, waits)
    assert shown.is_news is news


def test_a_ride_that_ends_is_put_off_or_gets_off_elsewhere_is_shown_as_that() -> None:
    over = shown(state=RideState.FAILED)
    assert (over.ends, over.vehicle_after) == (True, None)
    assert shown(ABOARD, to_stop="c").to_stop_after == "c"
    later = replace(PROMISE, pickup_from=minutes(65), pickup_to=minutes(70), arrive_by=minutes(80))
    put_off = shown(state=RideState.REQUESTED, vehicle_id=None, promise=later)
    assert (put_off.ends, put_off.postponed_to) == (False, minutes(65))
    assert shown(vehicle_id="shuttle-2", promise=later).postponed_to is None
