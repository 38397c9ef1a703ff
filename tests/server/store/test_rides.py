"""Rides, taps and recurring bookings: what is stored is found again, by everything they are looked up by."""

from dataclasses import replace
from datetime import date, timedelta, timezone

import pytest

from server.domain.rides.rides import Promise, Ride, RideState, Tap
from server.domain.rides.series import Occurrence, OccurrenceState, Series, SeriesState
from tests.server.store.conftest import Record
from tests.server.usecases.campus_under_test import MORNING as NOW

HOUR, SECOND = timedelta(hours=1), timedelta(seconds=1)
MONDAY = date(2026, 11, 23)
RIDE = Ride(
    campus_id="snow-lion",
    ride_id="ride-1",
    ride_code="ACDEFG",
    ticket_key_id="key-a",
    state=RideState.REQUESTED,
    from_stop="NN20",
    to_stop="C6",
    party=2,
    wheelchairs=1,
    earliest=NOW,
    requested_at=NOW,
    source="passenger",
)
FULL = replace(
    RIDE,
    state=RideState.ABOARD,
    promise=Promise(NOW, NOW + HOUR, NOW + 2 * HOUR),
    first_promise=Promise(NOW, NOW + SECOND, NOW + HOUR),
    vehicle_id="shuttle-1",
    pickup_eta=NOW + SECOND,
    arrival_eta=NOW + HOUR,
    boarded_at=NOW + 2 * SECOND,
    boarded_how="code",
    ended_at=NOW + 3 * SECOND,
    reason="seats",
    reason_detail="too few",
    promise_broken=True,
    left_early=True,
    idempotency_key="key-1",
    arrive_before=NOW + 2 * HOUR,
    first_to_stop="NN20",
    let_out=True,
    series_id="series-1",
    stranded_by="shuttle-2",
    pinned=True,
)
SERIES = Series(
    "snow-lion", "series-1", "key-a", "NN20", "C6", 2, 1, (0, 4), 28800,
    MONDAY, MONDAY + timedelta(days=30), NOW, "passenger", idempotency_key="key-9",
)  # fmt: skip


def numbered(count: int, **changes: object) -> list[Ride]:
    """Rides, each requested a second after the one before."""
    return [
        replace(
            RIDE,
            ride_id=f"ride-{n}",
            ride_code=f"CODE{n:02d}",
            requested_at=NOW + n * SECOND,
            **changes,  # type: ignore[arg-type]
        )
        for n in range(count)
    ]


def added(record: Record, *rides: Ride) -> None:
    record.do(lambda uow: [uow.rides.add(ride) for ride in rides])


@pytest.mark.parametrize("ride", [RIDE, FULL], ids=["new", "full"])
def test_a_ride_is_found_as_it_was_stored_by_its_id_code_and_key(record: Record, ride: Ride) -> None:
    added(record, ride)
    assert record.found(lambda uow: uow.rides.get("ride-1")) == ride
    assert record.found(lambda uow: uow.rides.by_code("ACDEFG")) == ride
    keyed = record.found(lambda uow: uow.rides.by_idempotency_key("key-1"))
    assert keyed == (ride if ride.idempotency_key else None)
    for missing in ("ride-2", ""):
        assert record.found(lambda uow, i=missing: uow.rides.get(i)) is None  # type: ignore[misc]
    assert record.found(lambda uow: uow.rides.by_code("ZZZZZZ")) is None


def test_pickups_are_those_from_a_moment_on_and_before_another(record: Record) -> None:
    rides = [replace(ride, earliest=NOW + n * HOUR) for n, ride in enumerate(numbered(3))]
    added(record, *rides)
    expected = tuple((ride.from_stop, ride.earliest) for ride in rides)
    assert record.found(lambda uow: uow.views.pickups(NOW, NOW + 2 * HOUR)) == expected[:2]
    assert record.found(lambda uow: uow.views.pickups(NOW + SECOND, NOW + 3 * HOUR)) == expected[1:]


def test_an_instant_given_in_another_time_zone_is_stored_as_the_same_instant(record: Record) -> None:
    shanghai = NOW.astimezone(timezone(timedelta(hours=8)))
    added(record, replace(RIDE, earliest=shanghai))
    stored = record.found(lambda uow: uow.rides.get("ride-1"))
    assert stored is not None
    assert stored.earliest == NOW
    assert stored.earliest.utcoffset() == timedelta()


def test_a_change_in_the_same_transaction_is_seen_by_every_search_of_it(record: Record) -> None:
    def change(uow):  # type: ignore[no-untyped-def]
        uow.rides.add(RIDE)
        uow.rides.save(replace(RIDE, state=RideState.CANCELLED, vehicle_id="shuttle-1"))
        states = (RideState.CANCELLED,)
        return (
            uow.rides.in_states(states),
            uow.rides.of_vehicle("shuttle-1", states),
            uow.rides.by_code("ACDEFG"),
        )

    changed = replace(RIDE, state=RideState.CANCELLED, vehicle_id="shuttle-1")
    assert record.do(change) == ((changed,), (changed,), changed)


def test_rides_are_listed_by_state_and_vehicle_oldest_request_first(record: Record) -> None:
    one, two, three = numbered(3)
    mine = replace(two, state=RideState.ASSIGNED, vehicle_id="shuttle-1")
    added(record, three, mine, one)
    assert record.found(lambda uow: uow.rides.in_states([RideState.REQUESTED])) == (one, three)
    everything = [RideState.REQUESTED, RideState.ASSIGNED]
    assert record.found(lambda uow: uow.rides.in_states(everything)) == (one, mine, three)
    assert record.found(lambda uow: uow.rides.of_vehicle("shuttle-1", everything)) == (mine,)
    assert record.found(lambda uow: uow.rides.of_vehicle("shuttle-1", [RideState.REQUESTED])) == ()
    assert record.found(lambda uow: uow.rides.of_vehicle("shuttle-2", everything)) == ()


def test_a_code_in_use_is_that_of_a_ride_that_has_not_ended(record: Record) -> None:
    old = replace(RIDE, ride_id="ride-0", state=RideState.COMPLETED)
    added(record, old)
    assert not record.found(lambda uow: uow.rides.code_in_use("ACDEFG"))
    assert record.found(lambda uow: uow.rides.by_code("ACDEFG")) == old
    added(record, RIDE, replace(old, ride_id="ride-9", requested_at=NOW + HOUR))
    assert record.found(lambda uow: uow.rides.code_in_use("ACDEFG"))
    assert record.found(lambda uow: uow.rides.by_code("ACDEFG")) == RIDE


def test_rides_wanted_in_a_time_begin_at_its_first_moment_and_end_before_its_last(record: Record) -> None:
    rides = [replace(ride, earliest=NOW + n * HOUR) for n, ride in enumerate(numbered(3))]
    added(record, *rides)
    wanted = record.found(lambda uow: uow.rides.wanted_between(NOW, NOW + 2 * HOUR))
    assert wanted == tuple(rides[:2])


def test_a_booking_is_known_by_its_key_for_as_long_as_its_ride_lasts_and_after_it(record: Record) -> None:
    keyed, other = replace(RIDE, idempotency_key="key-1"), replace(numbered(3)[2], idempotency_key="key-2")
    find = lambda uow: uow.rides.by_idempotency_key("key-1")  # noqa: E731
    added(record, keyed)
    assert record.found(find) == keyed
    added(record, other)
    for state in (RideState.ASSIGNED, RideState.ABOARD, RideState.COMPLETED):
        later = replace(keyed, state=state)
        record.do(lambda uow, later=later: uow.rides.save(later))  # type: ignore[misc]
        assert record.found(find) == later
    assert record.found(lambda uow: uow.rides.by_idempotency_key("key-2")) == other
    assert record.found(lambda uow: uow.rides.by_idempotency_key("key-3")) is None


def test_pages_of_rides_go_back_from_the_newest(record: Record) -> None:
    rides = numbered(5)
    added(record, *rides)
    first = record.found(lambda uow: uow.views.rides(limit=2))
    assert first == (rides[4], rides[3])
    older = record.found(lambda uow: uow.views.rides(limit=2, before=first[-1].requested_at))
    assert older == (rides[2], rides[1])
    assert record.found(lambda uow: uow.views.rides(states=[RideState.ABOARD])) == ()
    assert record.found(lambda uow: uow.views.rides(ride_ids={"ride-2"})) == (rides[2],)


def test_taps_wait_until_they_are_answered(record: Record) -> None:
    tap = Tap("snow-lion", "tap-1", "ride-1", "shuttle-1", "board", NOW)
    other = Tap("snow-lion", "tap-2", "ride-1", "shuttle-2", "alight", NOW)
    record.do(lambda uow: (uow.rides.add_tap(tap), uow.rides.add_tap(other)))
    assert record.found(lambda uow: uow.rides.pending_taps("shuttle-1")) == (tap,)
    answered = replace(tap, state="refused", reason="doors are closed")
    record.do(lambda uow: uow.rides.save_tap(answered))
    assert record.found(lambda uow: uow.rides.pending_taps("shuttle-1")) == ()
    assert record.found(lambda uow: uow.rides.tap("tap-1")) == answered
    assert record.found(lambda uow: uow.rides.tap("tap-3")) is None


def test_a_recurring_booking_is_found_by_its_id_and_key_and_listed_newest_first(record: Record) -> None:
    later = replace(SERIES, series_id="series-2", idempotency_key=None, made_at=NOW + HOUR)
    ended = replace(SERIES, state=SeriesState.CANCELLED, ended_at=NOW + HOUR)
    record.do(lambda uow: (uow.series.add(SERIES), uow.series.add(later)))
    assert record.found(lambda uow: uow.series.get("series-1")) == SERIES
    assert record.found(lambda uow: uow.series.by_idempotency_key("key-9")) == SERIES
    assert record.found(lambda uow: uow.series.get("series-3")) is None
    assert record.found(lambda uow: uow.series.listed()) == (later, SERIES)
    assert record.found(lambda uow: uow.series.listed(limit=1)) == (later,)
    record.do(lambda uow: uow.series.save(ended))
    assert record.found(lambda uow: uow.series.listed([SeriesState.ACTIVE])) == (later,)
    assert record.found(lambda uow: uow.series.listed([SeriesState.CANCELLED])) == (ended,)


def test_the_days_of_a_recurring_booking_are_listed_by_day_both_ends_included(record: Record) -> None:
    days = [
        Occurrence("snow-lion", "series-1", MONDAY + timedelta(days=n), NOW + n * 24 * HOUR) for n in range(3)
    ]
    record.do(lambda uow: uow.series.add(SERIES))
    record.do(lambda uow: [uow.series.save_occurrence(day) for day in reversed(days)])
    booked = replace(days[1], state=OccurrenceState.BOOKED, ride_id="ride-1", reason="r", tried_at=NOW)
    record.do(lambda uow: uow.series.save_occurrence(booked))
    expected = (days[0], booked, days[2])
    assert record.found(lambda uow: uow.series.occurrences("series-1")) == expected
    between = record.found(lambda uow: uow.series.occurrences_between(days[0].day, days[1].day))
    assert between == expected[:2]
    assert record.found(lambda uow: uow.series.occurrence("series-1", days[1].day)) == booked
    assert record.found(lambda uow: uow.series.occurrence("series-1", MONDAY - timedelta(days=1))) is None
