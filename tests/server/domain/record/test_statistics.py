"""Figures of a service: what an operator would count by hand."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta

from hypothesis import given
from hypothesis import strategies as st

from server.domain.record.statistics import ServiceFigures, service_figures
from server.domain.rides.rides import Promise, Ride, RideState
from tests.server.store.test_rides import RIDE

NOON = datetime(2026, 11, 25, 4, 0, tzinfo=UTC)  # in Shanghai
MINUTE = timedelta(minutes=1)
OVER = (RideState.COMPLETED, RideState.REFUSED, RideState.CANCELLED, RideState.NO_SHOW, RideState.FAILED)


def a_ride(
    wanted_min: float = 0.0, boarded_min: float | None = None, state: RideState = RideState.COMPLETED
) -> Ride:
    """Wanted and boarded so many minutes after noon; promised within 5 minutes."""
    wanted = NOON + wanted_min * MINUTE
    return replace(
        RIDE,
        state=state,
        earliest=wanted,
        requested_at=wanted,
        boarded_at=None if boarded_min is None else NOON + boarded_min * MINUTE,
        promise=Promise(wanted, wanted + 5 * MINUTE, wanted + 20 * MINUTE),
    )


def figures(rides: Sequence[Ride], timezone: str = "Asia/Shanghai") -> ServiceFigures:
    return service_figures(rides, 0, 1, timezone, is_cut=False)


def test_rides_are_counted_in_the_hour_of_the_campus_in_which_they_were_wanted() -> None:
    rides = [
        a_ride(0),
        a_ride(59, state=RideState.REFUSED),
        a_ride(61, state=RideState.NO_SHOW),
        a_ride(62, state=RideState.ABOARD),
    ]
    hours = figures(rides).hours
    assert [hour.hour for hour in hours] == list(range(24))
    assert (hours[12].completed, hours[12].refused, hours[12].passengers) == (1, 1, RIDE.party)
    assert (hours[13].no_show, hours[13].under_way, hours[13].passengers) == (1, 1, 0)
    assert figures(rides, "UTC").hours[4].completed == 1


def test_who_was_picked_up_in_the_promised_window_was_not_late() -> None:
    found = figures([a_ride(0, 3), a_ride(0, 5), a_ride(0, 8), a_ride(0, None, RideState.CANCELLED)])
    assert found.waiting_s.count == 3
    assert found.waiting_s.p50 == 300.0
    assert (found.late_s.count, found.late_s.p50) == (3, 0.0)
    assert found.kept_ratio == 2 / 3


def test_an_early_shuttle_makes_nobody_wait_less_than_no_time() -> None:
    assert figures([a_ride(10, 8)]).waiting_s.p50 == 0.0


def test_the_busiest_pairs_come_first() -> None:
    back = replace(a_ride(), from_stop=RIDE.to_stop, to_stop=RIDE.from_stop)
    pairs = figures([a_ride(), back, back]).pairs
    assert [(pair.from_stop, pair.rides) for pair in pairs] == [(RIDE.to_stop, 2), (RIDE.from_stop, 1)]


def test_a_quiet_day_has_figures_too() -> None:
    found = figures([])
    assert found.waiting_s.count == 0
    assert found.kept_ratio == 0.0
    assert len(found.hours) == 24


@given(
    st.lists(
        st.builds(
            a_ride,
            st.floats(0, 10_000),
            st.one_of(st.none(), st.floats(0, 10_000)),
            st.sampled_from(list(RideState)),
        ),
        max_size=40,
    )
)
def test_every_ride_is_counted_once_and_quantiles_are_in_order(rides: list[Ride]) -> None:
    found = figures(rides)
    counted = sum(
        hour.completed + hour.refused + hour.cancelled + hour.no_show + hour.failed + hour.under_way
        for hour in found.hours
    )
    assert counted == len(rides)
    for values in (found.waiting_s, found.late_s):
        assert 0.0 <= values.p50 <= values.p90 <= values.p99
    assert 0.0 <= found.kept_ratio <= 1.0
