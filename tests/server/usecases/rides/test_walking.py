"""Parties who would walk to another stop."""

import itertools
import math

from server.domain.rides.rides import RideState
from tests.server.usecases.fake_fleet import FakeFleet


def apart_m(fleet: FakeFleet, one: str, other: str) -> float:
    places = [fleet.network.stops[stop_id] for stop_id in (one, other)]
    (ax, ay, _), (bx, by, _) = (fleet.network.pose(stop.lane_id, stop.s_m) for stop in places)
    return math.hypot(ax - bx, ay - by)


def test_who_would_walk_may_get_other_stops_within_walking_distance(fleet: FakeFleet) -> None:
    walked = 0
    for from_stop, to_stop in itertools.permutations(sorted(fleet.network.stops), 2):
        ride = fleet.book(from_stop, to_stop, may_walk=True)
        if ride.state is RideState.REFUSED:
            break
        assert apart_m(fleet, ride.from_stop, from_stop) <= fleet.campus.rules.walk_m_max
        assert apart_m(fleet, ride.to_stop, to_stop) <= fleet.campus.rules.walk_m_max
        assert ride.from_stop != ride.to_stop
        assert ride.promise is not None
        walked += (ride.from_stop, ride.to_stop) != (from_stop, to_stop)
    assert walked > 0


def test_the_promise_leaves_time_for_the_walk(fleet: FakeFleet) -> None:
    for from_stop, to_stop in itertools.permutations(sorted(fleet.network.stops), 2):
        ride = fleet.book(from_stop, to_stop, may_walk=True)
        if ride.from_stop != from_stop and ride.promise is not None:
            walk_s = apart_m(fleet, ride.from_stop, from_stop) / fleet.campus.rules.walk_mps
            assert (ride.promise.pickup_from - ride.earliest).total_seconds() >= walk_s
            return
    raise AssertionError("nobody walked")


def test_a_repeated_booking_of_somebody_who_walks_is_the_same_ride(fleet: FakeFleet) -> None:
    first = fleet.book("NN20", "C6", may_walk=True, idempotency_key="key-12345678")
    assert fleet.book("NN20", "C6", may_walk=True, idempotency_key="key-12345678") == first


def test_nobody_walks_who_did_not_say_so(fleet: FakeFleet) -> None:
    for from_stop, to_stop in itertools.permutations(sorted(fleet.network.stops), 2):
        ride = fleet.book(from_stop, to_stop)
        assert (ride.from_stop, ride.to_stop) == (from_stop, to_stop)
