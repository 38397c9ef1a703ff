"""Roads closed by operators: who is refused, told, turned away and let out, until the road opens."""

from collections.abc import Iterator
from datetime import timedelta

import pytest

from server.domain.errors import (
    ClosureInvalid,
    ClosureOver,
    ClosureUnknown,
    DestinationRefused,
    LaneUnknown,
    SectionUnknown,
)
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import BookRide, Ride, RideState
from server.domain.roads.closures import Closure, ClosureState
from server.usecases.fleet import closures
from server.usecases.fleet.closures import CloseRoad
from server.usecases.rides import destinations, rides
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

# The lanes at which the stops C6 and C1 lie. Roads are one-way: with C6 closed nobody leaves NN20, with C1
# closed the stops from SE13 to 1B can still be come to.
AT_C6 = ("east-4",)
AT_C1 = ("east-12",)


def close(fleet: FakeFleet, lane_ids: tuple[str, ...] = AT_C6, **more: object) -> Closure:
    wish = CloseRoad(lane_ids, reason="water main", **more)  # type: ignore[arg-type]
    return fleet.campus.do(lambda uow: closures.close(uow, wish, "ann"))


def lift(fleet: FakeFleet, closure: Closure) -> Closure:
    return fleet.campus.do(lambda uow: closures.lift(uow, closure.closure_id, "ann"))


def causes(fleet: FakeFleet, kind: IncidentKind) -> list[str]:
    return [i.cause for i in fleet.campus.read(lambda uow: uow.incidents.all_open()) if i.kind is kind]


def drive_until(fleet: FakeFleet, ride: Ride, state: RideState, limit_steps: int = 1500) -> Ride:
    for _ in range(limit_steps):
        if fleet.ride(ride.ride_id).state is state:
            return fleet.ride(ride.ride_id)
        fleet.step()
    raise AssertionError(f"{fleet.ride(ride.ride_id)}\n{fleet.stuck()}")


def require_off(fleet: FakeFleet, lanes: tuple[str, ...]) -> None:
    """Nobody is granted closed road."""
    for occupancy in fleet.campus.read(lambda uow: uow.sections.all()):
        held = {fleet.network.sections[section_id].lane_id for section_id in occupancy.held_ids}
        assert not held & set(lanes), occupancy


def test_what_cannot_be_closed_is_named(fleet: FakeFleet) -> None:
    campus = fleet.campus
    now = campus.clock.now()
    for wish, error in (
        (CloseRoad(("nowhere",)), LaneUnknown),
        (CloseRoad(section_ids=("nowhere",)), SectionUnknown),
        (CloseRoad(), ClosureInvalid),
        (
            CloseRoad(AT_C6, starts_at=now + timedelta(hours=2), ends_at=now + timedelta(hours=1)),
            ClosureInvalid,
        ),
        (CloseRoad(AT_C6, starts_at=now - timedelta(hours=2), ends_at=now), ClosureInvalid),
    ):
        with pytest.raises(error):
            campus.do(lambda uow, wish=wish: closures.close(uow, wish, "ann"))
    with pytest.raises(ClosureUnknown):
        campus.do(lambda uow: closures.lift(uow, "closure-0", "ann"))
    assert campus.read(lambda uow: uow.closures.standing()) == ()


def test_the_record_says_who_closed_and_opened_a_road_and_what_began_and_ended_by_itself(
    fleet: FakeFleet,
) -> None:
    now = fleet.campus.clock.now()
    closure = close(fleet, starts_at=now + timedelta(minutes=5), ends_at=now + timedelta(minutes=10))
    for minute in (6, 11):
        fleet.campus.clock.advance(
            (now + timedelta(minutes=minute) - fleet.campus.clock.now()).total_seconds()
        )
        fleet.campus.do(closures.update_closures)
    other = close(fleet, AT_C1)
    lift(fleet, other)
    told = fleet.campus.read(lambda uow: uow.views.server_events())
    made = {
        closure_id: [(e.name, e.by, e.detail) for e in reversed(told) if e.subject == closure_id]
        for closure_id in (closure.closure_id, other.closure_id)
    }
    assert made[closure.closure_id] == [
        ("road.closed", "ann", "east-4: water main"),
        ("road.closure_began", "", "east-4: water main"),
        ("road.opened", "", "east-4: water main"),
    ]
    assert [(name, by) for name, by, _ in made[other.closure_id]] == [
        ("road.closed", "ann"),
        ("road.closure_began", ""),
        ("road.opened", "ann"),
    ]


def test_a_stop_on_closed_road_is_refused_with_another_one_instead_until_it_opens(fleet: FakeFleet) -> None:
    closure = close(fleet, AT_C1)
    assert closure.state is ClosureState.IN_FORCE
    answer = fleet.campus.do(lambda uow: rides.book_all(uow, [BookRide("SE13", "C1", party=1)]))[0]
    assert isinstance(answer, rides.BookingResult)
    assert (answer.ride.state, answer.ride.reason) == (RideState.REFUSED, "closed_road")
    assert ("other_stops", "SE13", "1B") in {
        (found.kind, found.from_stop, found.to_stop) for found in answer.alternatives
    }
    assert "C1" not in {found.to_stop for found in answer.alternatives}
    assert fleet.book("C1", "SE13").reason == "closed_road"
    assert fleet.book("SE13", "1B").state is RideState.ASSIGNED
    over = lift(fleet, closure)
    assert (over.state, over.lifted_by) == (ClosureState.OVER, "ann")
    assert fleet.book("SE13", "C1").state is RideState.ASSIGNED
    with pytest.raises(ClosureOver):
        lift(fleet, closure)


def test_a_ride_during_which_its_destination_will_be_closed_is_told_before_the_closure_begins(
    fleet: FakeFleet,
) -> None:
    ride = fleet.book("SE13", "C1")
    assert ride.pickup_eta is not None
    assert ride.arrival_eta is not None
    begins = ride.pickup_eta + 0.5 * (ride.arrival_eta - ride.pickup_eta)
    closure = close(fleet, AT_C1, starts_at=begins, ends_at=begins + timedelta(hours=1))
    assert closure.state is ClosureState.SCHEDULED
    told = fleet.ride(ride.ride_id)
    assert told.promise_broken
    assert told.promise is not None
    assert closure.ends_at is not None
    assert told.promise.pickup_from >= closure.ends_at


def test_a_booking_is_refused_when_the_road_closes_while_it_would_be_under_way(fleet: FakeFleet) -> None:
    free = fleet.book("SE13", "C1")
    assert free.pickup_eta is not None
    assert free.arrival_eta is not None
    tomorrow = fleet.campus.clock.now() + timedelta(days=1)
    half_way = 0.5 * (free.arrival_eta - free.pickup_eta)
    close(fleet, AT_C1, starts_at=tomorrow + half_way, ends_at=tomorrow + timedelta(hours=1))
    assert fleet.book("SE13", "C1", earliest=tomorrow).reason == "closed_road"
    before = tomorrow - timedelta(hours=1)
    assert fleet.book("SE13", "C1", earliest=before).state is RideState.ASSIGNED


def test_a_ride_cannot_be_changed_to_a_closed_stop(fleet: FakeFleet) -> None:
    close(fleet, AT_C1)
    ride = fleet.book("SE13", "1B")
    with pytest.raises(DestinationRefused) as refused:
        fleet.campus.do(lambda uow: destinations.change_destination(uow, ride, "C1", "passenger"))
    assert refused.value.rule == "closed_road"
    assert fleet.ride(ride.ride_id) == ride


def test_who_waits_at_a_stop_that_is_cut_off_for_a_time_is_told_early_and_fetched_after_it(
    driven_fleet: FakeFleet,
) -> None:
    fleet = driven_fleet
    ride = fleet.book("C1", "SE13")
    ends_at = fleet.campus.clock.now() + timedelta(minutes=40)
    close(fleet, AT_C1, ends_at=ends_at)
    told = fleet.ride(ride.ride_id)
    assert (told.state, told.vehicle_id, told.promise_broken) == (RideState.REQUESTED, None, True)
    assert told.promise is not None
    assert told.promise.pickup_from >= ends_at
    assert told.first_promise == ride.promise
    assert any("water main" in cause for cause in causes(fleet, IncidentKind.PROMISE_BROKEN))
    while fleet.campus.clock.now() < ends_at - timedelta(seconds=10):
        fleet.step()
        require_off(fleet, AT_C1)
        assert fleet.ride(ride.ride_id).promise == told.promise
    done = drive_until(fleet, ride, RideState.COMPLETED)
    assert done.boarded_at is not None
    assert told.promise.pickup_from <= done.boarded_at <= told.promise.pickup_to + timedelta(seconds=60)
    assert done.promise == told.promise


def test_who_waits_where_nobody_can_come_any_more_is_told_so(fleet: FakeFleet) -> None:
    ride = fleet.book("C6", "SE13")
    closure = close(fleet)
    failed = fleet.ride(ride.ride_id)
    assert (failed.state, failed.reason) == (RideState.FAILED, "closed_road")
    assert closure.closure_id in failed.reason_detail
    assert "water main" in failed.reason_detail
    assert any(closure.closure_id in cause for cause in causes(fleet, IncidentKind.RIDE_FAILED))
    plans = fleet.campus.read(lambda uow: uow.plans.all())
    assert all(ride.ride_id not in plan.ride_ids for plan in plans)


def test_riders_aboard_are_let_out_as_near_as_can_be(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN7", "C6")
    drive_until(fleet, ride, RideState.ABOARD)
    closure = close(fleet)
    told = fleet.ride(ride.ride_id)
    assert (told.state, told.first_to_stop) == (RideState.ABOARD, "C6")
    assert told.to_stop != "C6"
    assert any(closure.closure_id in cause for cause in causes(fleet, IncidentKind.ROAD_CLOSED))
    assert told.promise is not None
    assert told.arrival_eta is not None
    assert told.arrival_eta <= told.promise.arrive_by
    done = drive_until(fleet, ride, RideState.COMPLETED)
    assert not done.left_early


def test_a_shuttle_under_way_is_sent_another_way_and_is_granted_no_closed_road(
    driven_fleet: FakeFleet,
) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN7", "SE13")
    drive_until(fleet, ride, RideState.ABOARD)
    for _ in range(5):
        fleet.step()
    before = fleet.campus.read(lambda uow: uow.sections.all())
    assert any("east-7" in s for occupancy in before for s in (*occupancy.ahead, *occupancy.held_ids))
    close(fleet, ("east-7",))
    for _ in range(900):
        fleet.step()
        require_off(fleet, ("east-7",))
        if fleet.ride(ride.ride_id).has_ended:
            break
    done = fleet.ride(ride.ride_id)
    assert done.state is RideState.COMPLETED, fleet.stuck()


def test_a_shuttle_on_closed_road_leaves_it(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN7", "SE13")
    for _ in range(1500):
        fleet.step()
        shuttle = next((s for s in fleet.shuttles if s.aboard), None)
        if shuttle is not None and shuttle.place.lane_id == "east-4":
            break
    assert shuttle is not None
    assert shuttle.place.lane_id == "east-4"
    close(fleet)
    drive_until(fleet, ride, RideState.COMPLETED)
    assert not fleet.ride(ride.ride_id).promise_broken
    require_off(fleet, AT_C6)


def test_rides_of_another_time_than_the_closure_s_are_not_touched(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    now = fleet.campus.clock.now()
    early, late = now + timedelta(hours=2), now + timedelta(hours=4)
    closure = close(fleet, starts_at=early, ends_at=late)
    assert closure.state is ClosureState.SCHEDULED
    assert fleet.book("NN20", "C6").state is RideState.ASSIGNED
    within = fleet.book("NN20", "C6", earliest=early + timedelta(minutes=30))
    assert (within.state, within.reason) == (RideState.REFUSED, "closed_road")
    after = fleet.book("NN20", "C6", earliest=late + timedelta(minutes=10))
    assert after.state is RideState.ASSIGNED
    fleet.campus.clock.advance((early - now).total_seconds() + 600.0)
    fleet.step()
    fleet.step()
    assert [c.state for c in fleet.campus.read(lambda uow: uow.closures.standing())] == [
        ClosureState.IN_FORCE
    ]
    kept = fleet.ride(after.ride_id)
    assert (kept.promise, kept.promise_broken, kept.has_ended) == (after.promise, False, False)
    later = fleet.book("NN20", "C6", earliest=late + timedelta(minutes=20))
    assert (later.state, later.vehicle_id) == (RideState.REQUESTED, None)
    assert later.promise is not None
    assert later.promise.pickup_from >= late
    assert fleet.book("NN20", "C6").reason == "closed_road"
    fleet.campus.clock.advance((late - fleet.campus.clock.now()).total_seconds())
    fleet.step()
    fleet.step()
    assert fleet.campus.read(lambda uow: uow.closures.standing()) == ()
    for ride in (after, later):
        done = drive_until(fleet, ride, RideState.COMPLETED)
        assert done.promise == ride.promise
        assert not done.promise_broken


def test_a_promise_within_a_closure_to_come_is_told_anew_when_it_is_entered(fleet: FakeFleet) -> None:
    now = fleet.campus.clock.now()
    ride = fleet.book("NN20", "C6", earliest=now + timedelta(hours=3))
    ends_at = now + timedelta(hours=4)
    close(fleet, starts_at=now + timedelta(hours=2), ends_at=ends_at)
    told = fleet.ride(ride.ride_id)
    assert told.promise_broken
    assert told.promise is not None
    assert told.promise.pickup_from >= ends_at
    assert any("water main" in cause for cause in causes(fleet, IncidentKind.PROMISE_BROKEN))
    plans = fleet.campus.read(lambda uow: uow.plans.all())
    pickups = [visit for plan in plans for visit in plan.visits if ride.ride_id in visit.board]
    assert all(visit.not_before is not None and visit.not_before >= ends_at for visit in pickups)
    assert len(pickups) == (told.vehicle_id is not None)


def test_a_ride_of_tomorrow_stays_where_it_is_planned_while_its_road_may_still_open_in_time(
    fleet: FakeFleet,
) -> None:
    now = fleet.campus.clock.now()
    ride = fleet.book("NN20", "C6", earliest=now + timedelta(hours=20))
    planned = fleet.campus.read(lambda uow: uow.plans.all())
    close(fleet, starts_at=now + timedelta(hours=10))
    assert fleet.ride(ride.ride_id) == ride
    assert fleet.campus.read(lambda uow: uow.plans.all()) == planned


@pytest.fixture
def one_shuttle() -> Iterator[FakeFleet]:
    made = CampusUnderTest(shipped_map("snow-lion"))
    yield FakeFleet(made, shipped_map("snow-lion"), 1).start()
    made.close()


def test_a_shuttle_shut_in_with_its_riders_is_an_incident_and_goes_on_when_the_road_opens(
    one_shuttle: FakeFleet,
) -> None:
    fleet = one_shuttle
    ride = fleet.book("NN7", "SE13")
    drive_until(fleet, ride, RideState.ABOARD)
    every_lane = tuple(fleet.network.lanes)
    closure = close(fleet, every_lane)
    for _ in range(60):
        fleet.step()
    stays = fleet.ride(ride.ride_id)
    assert (stays.state, stays.to_stop) == (RideState.ABOARD, "SE13")
    assert any("no road leads out" in cause for cause in causes(fleet, IncidentKind.ROAD_CLOSED))
    lift(fleet, closure)
    assert drive_until(fleet, ride, RideState.COMPLETED).to_stop == "SE13"


def test_riders_whose_shuttle_has_nowhere_to_rest_are_let_out_first_and_an_operator_is_told(
    one_shuttle: FakeFleet,
) -> None:
    fleet = one_shuttle
    riding, other = fleet.book("NN7", "C6"), fleet.book("NN7", "NN20")
    for ride in (riding, other):
        drive_until(fleet, ride, RideState.ABOARD)
    fleet.leave_homeless("shuttle-1")
    close(fleet)
    told = fleet.ride(riding.ride_id)
    assert told.to_stop != "C6"
    plan = fleet.campus.read(lambda uow: uow.plans.get("shuttle-1"))
    assert plan is not None
    stops = [visit for visit in plan.visits if visit.kind == "stop" and visit.state == "pending"]
    assert [(visit.stop_id, visit.alight) for visit in stops] == [
        (told.to_stop, (riding.ride_id,)),
        ("NN20", (other.ride_id,)),
    ]
    assert any(told.to_stop in cause for cause in causes(fleet, IncidentKind.ROAD_CLOSED))
    assert any("shuttle-1" in cause for cause in causes(fleet, IncidentKind.NO_RESTING_PLACE))


def test_riders_for_whom_no_plan_keeps_every_promise_are_driven_to_their_exit_first(
    one_shuttle: FakeFleet, monkeypatch: pytest.MonkeyPatch
) -> None:
    fleet = one_shuttle
    ride = fleet.book("NN7", "C6")
    drive_until(fleet, ride, RideState.ABOARD)
    monkeypatch.setattr(destinations, "let_out_elsewhere", lambda *_: None)
    close(fleet)
    assert causes(fleet, IncidentKind.NO_RESTING_PLACE) == []
    assert drive_until(fleet, ride, RideState.COMPLETED).to_stop == "NN20"
