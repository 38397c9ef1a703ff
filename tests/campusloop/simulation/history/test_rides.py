"""What the history's rules about rides call broken, and what not."""

from campusloop.simulation.history.records import AcknowledgedBooking, StoredRide, VehicleFact
from campusloop.simulation.history.rides import (
    doubled_bookings,
    doubled_keys,
    forgotten_riders,
    lost_bookings,
    planned_twice,
    untrue_rides,
)

BOOKINGS = [AcknowledgedBooking(1.0, "key-1", "ride-1"), AcknowledgedBooking(2.0, "key-2", "ride-2")]


def a_ride(state: str = "assigned", due_s: float = 100.0, reason: str = "") -> StoredRide:
    has_ended = state not in ("assigned", "aboard")
    return StoredRide("ride-1", state, has_ended, reason, "shuttle-1", 1, due_s)


def test_an_acknowledged_booking_without_a_ride_is_lost() -> None:
    assert lost_bookings(9.0, BOOKINGS, {"ride-1", "ride-2"}) == []
    (lost,) = lost_bookings(9.0, BOOKINGS, {"ride-1"})
    assert (lost.rule, lost.subject) == ("booking_lost", "ride-2")


def test_two_rides_for_one_key_are_one_too_many_whether_answered_or_only_stored() -> None:
    again = AcknowledgedBooking(3.0, "key-1", "ride-1")
    other = AcknowledgedBooking(4.0, "key-1", "ride-3")
    assert doubled_bookings(9.0, [*BOOKINGS, again]) == []
    assert [v.subject for v in doubled_bookings(9.0, [*BOOKINGS, other])] == ["key-1"]
    assert doubled_keys(9.0, {"ride-1": "key-1", "ride-2": "key-2"}) == []
    assert [v.subject for v in doubled_keys(9.0, {"ride-1": "key-1", "ride-3": "key-1"})] == ["key-1"]


def test_a_rider_is_forgotten_when_the_ride_goes_on_long_after_it_was_due() -> None:
    assert forgotten_riders(159.0, [a_ride()], 60.0) == []
    assert [v.rule for v in forgotten_riders(161.0, [a_ride()], 60.0)] == ["rider_forgotten"]
    assert forgotten_riders(161.0, [a_ride("completed")], 60.0) == []
    assert [v.rule for v in forgotten_riders(1.0, [a_ride("failed")], 60.0)] == ["end_unexplained"]
    assert forgotten_riders(1.0, [a_ride("failed", reason="did_not_alight")], 60.0) == []


def test_a_ride_is_true_only_where_its_party_boarded_and_got_off() -> None:
    boarded = VehicleFact(1.0, "shuttle-1", "ride-1", "boarded")
    elsewhere = VehicleFact(1.0, "shuttle-2", "ride-1", "boarded")
    alighted = VehicleFact(2.0, "shuttle-1", "ride-1", "alighted")
    assert untrue_rides(9.0, [a_ride("completed")], [boarded, alighted]) == []
    for seen in ([], [elsewhere, alighted], [boarded]):
        assert [v.rule for v in untrue_rides(9.0, [a_ride("completed")], seen)] == ["ride_untrue"]
    assert untrue_rides(9.0, [a_ride("assigned")], []) == []


def test_a_ride_is_planned_on_one_vehicle_only() -> None:
    assert planned_twice(9.0, {"a": ("ride-1",), "b": ("ride-2",)}) == []
    assert [v.subject for v in planned_twice(9.0, {"a": ("ride-1",), "b": ("ride-1",)})] == ["ride-1"]
