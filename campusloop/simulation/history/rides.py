"""Rules about bookings and rides, judged over what was acknowledged and what is stored."""

from collections.abc import Collection, Iterable, Mapping, Sequence

from campusloop.simulation.history.records import (
    AcknowledgedBooking,
    StoredRide,
    VehicleFact,
    Violation,
)

# A ride that did not complete says why.
_WITH_REASON = frozenset({"refused", "cancelled", "no_show", "failed"})


def lost_bookings(
    at_s: float, acknowledged: Iterable[AcknowledgedBooking], stored: Collection[str]
) -> list[Violation]:
    """An acknowledged booking whose ride the store does not have. stored: ids of rides."""
    return [
        Violation(at_s, "booking_lost", booking.ride_id, f"acknowledged at {booking.at_s:.1f} s, not stored")
        for booking in acknowledged
        if booking.ride_id not in stored
    ]


def doubled_bookings(at_s: float, acknowledged: Iterable[AcknowledgedBooking]) -> list[Violation]:
    """One idempotency key that was answered with several rides."""
    rides_of: dict[str, set[str]] = {}
    for booking in acknowledged:
        rides_of.setdefault(booking.key, set()).add(booking.ride_id)
    return [
        Violation(at_s, "booking_doubled", key, f"the key was answered with {', '.join(sorted(rides))}")
        for key, rides in rides_of.items()
        if len(rides) > 1
    ]


def doubled_keys(at_s: float, key_of_ride: Mapping[str, str]) -> list[Violation]:
    """One idempotency key with several stored rides, answered or not. key_of_ride: by ride id."""
    rides_of: dict[str, list[str]] = {}
    for ride_id, key in key_of_ride.items():
        rides_of.setdefault(key, []).append(ride_id)
    return [
        Violation(at_s, "booking_doubled", key, f"the store has {', '.join(sorted(rides))} for one key")
        for key, rides in rides_of.items()
        if len(rides) > 1
    ]


def forgotten_riders(at_s: float, rides: Iterable[StoredRide], bound_s: float) -> list[Violation]:
    """A ride that has not ended bound_s after it was due, or that ended without a word why."""
    found = []
    for ride in rides:
        if not ride.has_ended and at_s > ride.due_s + bound_s:
            late_s = at_s - ride.due_s
            text = (
                f"still {ride.state} with {ride.vehicle_id or 'no vehicle'}, {late_s:.0f} s after it was due"
            )
            found.append(Violation(at_s, "rider_forgotten", ride.ride_id, text))
        if ride.state in _WITH_REASON and not ride.reason:
            found.append(Violation(at_s, "end_unexplained", ride.ride_id, f"{ride.state} without a reason"))
    return found


def untrue_rides(at_s: float, rides: Iterable[StoredRide], seen: Sequence[VehicleFact]) -> list[Violation]:
    """A ride that is stored as aboard or completed though no party boarded, or alighted, where it says."""
    boarded = {(fact.ride_id, fact.vehicle_id) for fact in seen if fact.what == "boarded"}
    alighted = {fact.ride_id for fact in seen if fact.what == "alighted"}
    found = []
    for ride in rides:
        here = (ride.ride_id, ride.vehicle_id or "")
        if ride.state in ("aboard", "completed") and here not in boarded:
            text = f"stored as {ride.state} with {here[1]}, where its party never boarded"
            found.append(Violation(at_s, "ride_untrue", ride.ride_id, text))
        elif ride.state == "completed" and ride.ride_id not in alighted:
            text = "stored as completed, but its party never got off"
            found.append(Violation(at_s, "ride_untrue", ride.ride_id, text))
    return found


def unreported_rides(
    at_s: float, rides: Iterable[StoredRide], seen: Sequence[VehicleFact]
) -> list[Violation]:
    """A party that got off at the end of its ride, and whose ride is not stored as completed."""
    last = {fact.ride_id: fact for fact in seen}
    return [
        Violation(at_s, "ride_unreported", ride.ride_id, f"its party got off; it is stored as {ride.state}")
        for ride in rides
        if ride.ride_id in last
        and last[ride.ride_id].what == "alighted"
        and ride.state not in ("completed", "failed", "cancelled", "requested", "assigned", "boarding")
    ]


def planned_twice(at_s: float, ride_ids_of: Mapping[str, Collection[str]]) -> list[Violation]:
    """A ride in the plans of two vehicles. ride_ids_of: by vehicle."""
    holder: dict[str, str] = {}
    found = []
    for vehicle_id, ride_ids in sorted(ride_ids_of.items()):
        for ride_id in sorted(ride_ids):
            other = holder.setdefault(ride_id, vehicle_id)
            if other != vehicle_id:
                text = f"planned on {other} and on {vehicle_id}"
                found.append(Violation(at_s, "ride_planned_twice", ride_id, text))
    return found
