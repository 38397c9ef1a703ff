"""A ride's states: every pair in one table."""

from dataclasses import replace
from datetime import UTC, datetime

import pytest

from server.domain.errors import IllegalTransition, RideAlreadyAboard, RideEnded
from server.domain.rides.rides import (
    ENDED,
    TRANSITIONS,
    Ride,
    RideState,
    assigned,
    boarded,
    cancelled,
    moved,
)

NOW = datetime(2026, 11, 23, 8, 0, tzinfo=UTC)
S = RideState

LEGAL = {
    (S.REQUESTED, S.ASSIGNED),
    (S.REQUESTED, S.REFUSED),
    (S.REQUESTED, S.CANCELLED),
    (S.REQUESTED, S.FAILED),
    (S.ASSIGNED, S.REQUESTED),
    (S.ASSIGNED, S.BOARDING),
    (S.ASSIGNED, S.ABOARD),
    (S.ASSIGNED, S.CANCELLED),
    (S.ASSIGNED, S.NO_SHOW),
    (S.ASSIGNED, S.FAILED),
    (S.BOARDING, S.REQUESTED),
    (S.BOARDING, S.ABOARD),
    (S.BOARDING, S.CANCELLED),
    (S.BOARDING, S.NO_SHOW),
    (S.BOARDING, S.FAILED),
    (S.REQUESTED, S.ABOARD),
    (S.ABOARD, S.REQUESTED),
    (S.ABOARD, S.COMPLETED),
    (S.ABOARD, S.FAILED),
    (S.CANCELLED, S.ABOARD),
    (S.NO_SHOW, S.ABOARD),
}


def a_ride(state: RideState = S.REQUESTED) -> Ride:
    return Ride(
        campus_id="campus",
        ride_id="ride-1",
        ride_code="ACDEFG",
        ticket_key_id="key",
        state=state,
        from_stop="a",
        to_stop="b",
        party=2,
        wheelchairs=0,
        earliest=NOW,
        requested_at=NOW,
        source="passenger",
    )


@pytest.mark.parametrize("before", list(RideState))
@pytest.mark.parametrize("after", list(RideState))
def test_a_ride_moves_only_as_the_table_says(before: RideState, after: RideState) -> None:
    if (before, after) in LEGAL:
        assert moved(a_ride(before), after).state is after
    else:
        with pytest.raises(IllegalTransition, match=str(before)):
            moved(a_ride(before), after)


def test_the_table_names_every_state() -> None:
    assert set(TRANSITIONS) == set(RideState)


def test_a_ride_that_ended_for_the_rider_stays_ended() -> None:
    final = {state for state in RideState if not TRANSITIONS[state]}
    assert final < ENDED


def test_somebody_aboard_can_no_longer_cancel() -> None:
    with pytest.raises(RideAlreadyAboard, match="seat button"):
        cancelled(a_ride(S.ABOARD), "passenger", NOW)


def test_an_ended_ride_cannot_be_cancelled_again() -> None:
    gone = cancelled(a_ride(S.ASSIGNED), "operator", NOW)
    assert (gone.state, gone.reason, gone.ended_at) == (S.CANCELLED, "cancelled_by_operator", NOW)
    with pytest.raises(RideEnded):
        cancelled(gone, "passenger", NOW)


def test_boarding_after_a_crossed_cancellation_takes_back_the_ending() -> None:
    gone = cancelled(assigned(a_ride(), "shuttle-1", NOW, NOW), "passenger", NOW)
    aboard = boarded(gone, "code", NOW)
    assert aboard.state is S.ABOARD
    assert (aboard.ended_at, aboard.reason) == (None, "")


def test_changing_one_ride_leaves_the_old_value_alone() -> None:
    ride = a_ride()
    assert moved(ride, S.ASSIGNED) != ride
    assert ride == replace(ride)
