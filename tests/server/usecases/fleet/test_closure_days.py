"""Days on which roads are closed and opened at random: no ride is lost, no promise breaks in silence."""

import os
from datetime import timedelta

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import Ride, RideState
from server.usecases.fleet import closures
from server.usecases.fleet.closures import CloseRoad
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

MAP = shipped_map("snow-lion")
LANES = [lane.lane_id for lane in MAP.lanes]
STOPS = [stop.stop_id for stop in MAP.stops]
SETTLED_WITHIN_STEPS = 4000
STORIES = int(os.environ.get("CAMPUSLOOP_STORIES", "0"))
# The plan is looked at every other step, and says so where a promise will be missed by this much.
LAPSE = timedelta(seconds=30)

a_closure = st.tuples(
    st.just("close"),
    st.lists(st.sampled_from(LANES), min_size=1, max_size=3, unique=True),
    st.sampled_from([0.0, 0.0, 300.0]),
    st.sampled_from([None, 300.0, 1200.0]),
)
a_booking = st.tuples(
    st.just("book"), st.sampled_from(STOPS), st.sampled_from(STOPS), st.sampled_from([0.0, 0.0, 1500.0])
)
a_drive = st.tuples(st.just("drive"), st.integers(5, 60))
a_lift = st.tuples(st.just("lift"), st.integers(0, 5))
days = st.lists(st.one_of(a_closure, a_booking, a_booking, a_drive, a_drive, a_lift), max_size=14)


class Day:
    def __init__(self) -> None:
        self.campus = CampusUnderTest(MAP)
        self.fleet = FakeFleet(self.campus, MAP, 3).start()
        for shuttle in self.fleet.shuttles:
            shuttle.speed_mps = 6.0
        self.known: dict[str, Ride] = {}

    def close(self, lanes: list[str], in_s: float, for_s: float | None) -> None:
        starts_at = self.campus.clock.now() + timedelta(seconds=in_s)
        ends_at = None if for_s is None else starts_at + timedelta(seconds=for_s)
        wish = CloseRoad(tuple(lanes), reason="test", starts_at=starts_at, ends_at=ends_at)
        self.campus.do(lambda uow: closures.close(uow, wish, "ann"))

    def lift(self, number: int) -> None:
        standing = self.campus.read(lambda uow: uow.closures.standing())
        if standing:
            closure_id = standing[number % len(standing)].closure_id
            self.campus.do(lambda uow: closures.lift(uow, closure_id, "ann"))

    def book(self, from_stop: str, to_stop: str, in_s: float) -> None:
        if from_stop != to_stop:
            self.fleet.book(from_stop, to_stop, earliest=self.campus.clock.now() + timedelta(seconds=in_s))

    def drive(self, steps: int) -> None:
        for _ in range(steps):
            self.fleet.step()
            self.require_told()

    def require_told(self) -> None:
        """Whoever's promise has moved or cannot be kept has been told so, with an incident."""
        told = {
            (incident.kind, incident.ride_id)
            for incident in self.campus.read(lambda uow: uow.incidents.all_open())
        }
        now = self.campus.clock.now()
        for ride in self.fleet.rides():
            before = self.known.get(ride.ride_id)
            self.known[ride.ride_id] = ride
            if ride.state is RideState.FAILED:
                assert (IncidentKind.RIDE_FAILED, ride.ride_id) in told, ride
            elif ride.promise is not None and before is not None and before.promise != ride.promise:
                moved = ride.to_stop != before.to_stop
                kind = IncidentKind.ROAD_CLOSED if moved else IncidentKind.PROMISE_BROKEN
                assert (kind, ride.ride_id) in told, (before, ride)
            if ride.promise is not None and not ride.has_ended:
                waits = ride.state in (RideState.REQUESTED, RideState.ASSIGNED)
                late = now > ride.promise.arrive_by + LAPSE
                late |= waits and now > ride.promise.pickup_to + LAPSE
                assert not late or (IncidentKind.PROMISE_BROKEN, ride.ride_id) in told, ride

    def require_kept(self) -> None:
        """Every ride that has not ended waits, or is in the plan of the vehicle that has it."""
        plans = {plan.vehicle_id: plan for plan in self.campus.read(lambda uow: uow.plans.all())}
        for ride in self.fleet.rides():
            if ride.has_ended:
                continue
            if ride.state is RideState.REQUESTED:
                assert ride.vehicle_id is None, ride
            else:
                assert ride.vehicle_id is not None, ride
                assert ride.ride_id in plans[ride.vehicle_id].ride_ids, ride

    def settle(self) -> None:
        """Every road is open again: all rides come to their ends."""
        for _ in self.campus.read(lambda uow: uow.closures.standing()):
            self.lift(0)
        assert not self.campus.read(lambda uow: uow.closures.standing())
        for _ in range(SETTLED_WITHIN_STEPS):
            if not self.fleet.waiting():
                return
            before = [shuttle.place for shuttle in self.fleet.shuttles]
            self.drive(1)
            if before == [shuttle.place for shuttle in self.fleet.shuttles]:
                self.campus.clock.advance(8.0)
        raise AssertionError(f"{self.fleet.waiting()}\n{self.fleet.stuck()}")


@pytest.mark.long
@settings(
    max_examples=STORIES or 6,
    deadline=None,
    derandomize=not STORIES,
    database=None,
    suppress_health_check=list(HealthCheck),
)
@given(days)
def test_no_closure_loses_a_ride_or_breaks_a_promise_in_silence(
    day: list[tuple[str, ...]],
) -> None:
    played = Day()
    try:
        for what, *details in day:
            getattr(played, what)(*details)
            played.require_kept()
            played.drive(2)
        played.settle()
    finally:
        played.campus.close()
