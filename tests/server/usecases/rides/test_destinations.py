"""Another destination while waiting and while riding, and getting off as soon as possible."""

import contextlib

import pytest

from server.domain.errors import (
    DestinationRefused,
    NoService,
    RideAlreadyAboard,
    RideEnded,
    SameStop,
    StopUnknown,
)
from server.domain.rides.rides import Ride, RideState
from server.domain.service.service import Hours, ServicePattern
from server.usecases.fleet import closures, service, vehicles
from server.usecases.fleet.closures import CloseRoad
from server.usecases.planning import plans
from server.usecases.planning.snapshot import seconds
from server.usecases.rides import destinations, rides
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle


def change(fleet: FakeFleet, ride: Ride, to_stop: str) -> Ride:
    return fleet.campus.do(
        lambda uow: destinations.change_destination(
            uow, rides.ride_of(uow, ride.ride_id), to_stop, "passenger"
        )
    )


def cancel(fleet: FakeFleet, ride: Ride) -> Ride:
    return fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "passenger"))


def until(fleet: FakeFleet, ride: Ride, state: RideState) -> Ride:
    for _ in range(1500):
        if fleet.ride(ride.ride_id).state is state:
            return fleet.ride(ride.ride_id)
        fleet.step()
    raise AssertionError(f"{fleet.ride(ride.ride_id).state}, not {state}")


def shuttle_of(fleet: FakeFleet, ride: Ride) -> FakeShuttle:
    return next(shuttle for shuttle in fleet.shuttles if shuttle.vehicle_id == ride.vehicle_id)


def alighting_stops(fleet: FakeFleet, ride: Ride) -> list[str]:
    plan = fleet.campus.read(lambda uow: plans.plan_of(uow, ride.vehicle_id or ""))
    return [visit.stop_id for visit in plan.visits if ride.ride_id in visit.alight]


def events(fleet: FakeFleet) -> list[str]:
    return [event.name for event in fleet.campus.read(lambda uow: uow.views.server_events())]


def test_a_waiting_ride_goes_elsewhere_with_its_pickup_promise_kept(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    changed = change(fleet, ride, "GYM")
    assert ride.promise is not None
    assert changed.promise is not None
    assert (changed.to_stop, changed.first_to_stop, changed.state) == ("GYM", "C6", RideState.ASSIGNED)
    assert (changed.promise.pickup_from, changed.promise.pickup_to) == (
        ride.promise.pickup_from,
        ride.promise.pickup_to,
    )
    assert changed.promise.arrive_by > ride.promise.arrive_by
    assert alighting_stops(fleet, changed) == ["GYM"]
    assert fleet.ride(ride.ride_id) == changed
    assert "ride.destination_changed" in events(fleet)


def test_wherever_a_waiting_party_wants_to_go_it_is_fetched_before_it_is_let_out(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    changed_to = 0
    for to_stop in sorted(fleet.network.stops):
        if to_stop == "NN20":
            continue
        with contextlib.suppress(DestinationRefused):
            ride = change(fleet, ride, to_stop)
            changed_to += 1
        plan = fleet.campus.read(lambda uow, r=ride: plans.plan_of(uow, r.vehicle_id or ""))  # type: ignore[misc]
        (boards,) = (n for n, visit in enumerate(plan.visits) if ride.ride_id in visit.board)
        (alights,) = (n for n, visit in enumerate(plan.visits) if ride.ride_id in visit.alight)
        assert boards < alights
        assert plan.visits[alights].stop_id == ride.to_stop
    assert changed_to > 5


def test_back_to_the_first_destination_it_is_as_if_it_had_never_changed(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    change(fleet, ride, "GYM")
    back = change(fleet, ride, "C6")
    assert (back.to_stop, back.first_to_stop) == ("C6", None)
    assert change(fleet, ride, "C6") == back


def test_who_joins_another_party_s_stop_takes_no_later_stop_from_anybody(fleet: FakeFleet) -> None:
    """One shuttle for three; the one who rides farthest wants to get off where the first one does."""
    fleet.shuttles[1].hold()
    made = [fleet.book("NN20", to_stop) for to_stop in ("C6", "C1", "SE13")]
    assert len({ride.vehicle_id for ride in made}) == 1
    plan = fleet.campus.read(lambda uow: plans.plan_of(uow, made[0].vehicle_id or ""))
    order = [ride_id for visit in plan.visits for ride_id in visit.alight]
    first, farthest = (next(r for r in made if r.ride_id == order[n]) for n in (0, -1))
    changed = change(fleet, farthest, first.to_stop)
    assert changed.to_stop == first.to_stop
    after = fleet.campus.read(lambda uow: plans.plan_of(uow, made[0].vehicle_id or ""))
    for ride in made:
        fresh = fleet.ride(ride.ride_id)
        assert alighting_stops(fleet, fresh) == [fresh.to_stop]
        assert sum(ride.ride_id in visit.board for visit in after.visits) == 1
    together = [visit for visit in after.visits if first.ride_id in visit.alight]
    assert farthest.ride_id in together[0].alight


def test_what_is_no_destination_is_an_error_and_changes_nothing(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    with pytest.raises(StopUnknown):
        change(fleet, ride, "NOWHERE")
    with pytest.raises(SameStop):
        change(fleet, ride, "NN20")
    assert fleet.ride(ride.ride_id) == ride
    cancel(fleet, ride)
    with pytest.raises(RideEnded):
        change(fleet, ride, "GYM")


def test_riders_are_driven_to_where_they_want_to_go_now(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    aboard = until(driven_fleet, ride, RideState.ABOARD)
    changed = change(driven_fleet, ride, "GYM")
    assert changed.promise is not None
    assert aboard.promise is not None
    assert changed.promise.arrive_by > aboard.promise.arrive_by
    assert (changed.state, alighting_stops(driven_fleet, changed)) == (RideState.ABOARD, ["GYM"])
    driven_fleet.run_until_idle(6000.0)
    done = driven_fleet.ride(ride.ride_id)
    assert (done.state, done.left_early, done.promise_broken) == (RideState.COMPLETED, False, False)
    assert shuttle_of(driven_fleet, ride).rejected == []


def test_a_party_at_the_open_door_keeps_its_shuttle(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    boarding = until(driven_fleet, ride, RideState.BOARDING)
    changed = change(driven_fleet, ride, "GYM")
    assert (changed.vehicle_id, changed.state) == (boarding.vehicle_id, RideState.BOARDING)
    driven_fleet.run_until_idle(6000.0)
    assert driven_fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_somebody_who_rides_may_even_go_back(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    until(driven_fleet, ride, RideState.ABOARD)
    assert change(driven_fleet, ride, "NN20").to_stop == "NN20"
    driven_fleet.run_until_idle(6000.0)
    assert driven_fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_a_change_that_would_break_another_s_promise_is_refused_with_the_rule(
    driven_fleet: FakeFleet,
) -> None:
    fleet = driven_fleet
    fleet.shuttles[1].hold()
    riding = fleet.book("NN7", "NN20", 4)
    waiting = fleet.book("NN20", "C6", 4, earliest=riding.arrival_eta)
    assert riding.vehicle_id == waiting.vehicle_id
    before = until(fleet, riding, RideState.ABOARD)
    with pytest.raises(DestinationRefused, match="stays as it was") as refused:
        change(fleet, riding, "C1")
    assert refused.value.rule == "arrival"
    assert fleet.ride(riding.ride_id).to_stop == before.to_stop
    fleet.run_until_idle(6000.0)
    assert fleet.ride(waiting.ride_id).state is RideState.COMPLETED


def test_a_rider_who_goes_farther_waits_for_the_others_to_get_off(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    fleet.shuttles[1].hold()
    farther, other = fleet.book("NN7", "NN20"), fleet.book("NN7", "C6")
    until(fleet, farther, RideState.ABOARD)
    until(fleet, other, RideState.ABOARD)
    change(fleet, farther, "C1")
    plan = fleet.campus.read(lambda uow: plans.plan_of(uow, farther.vehicle_id or ""))
    assert [visit.stop_id for visit in plan.visits if visit.alight] == ["C6", "C1"]


def test_a_waiting_ride_that_cannot_be_redirected_stays_as_it_was(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    for shuttle in fleet.shuttles:
        fleet.campus.do(lambda uow, name=shuttle.vehicle_id: vehicles.recall(uow, name, "ann"))
    waiting = fleet.ride(ride.ride_id)
    with pytest.raises(DestinationRefused) as refused:
        change(fleet, ride, "GYM")
    assert refused.value.rule == "no_vehicle_free"
    assert fleet.ride(ride.ride_id) == waiting


def test_a_shuttle_that_is_almost_there_still_stops_for_its_party(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    shuttle = shuttle_of(driven_fleet, ride)
    visit_id = driven_fleet.campus.read(lambda uow: plans.plan_of(uow, shuttle.vehicle_id)).visits[0].visit_id
    driven_fleet.run_until(
        lambda: shuttle.line is not None and (shuttle.line.visit_s(visit_id) or 0.0) - shuttle.s_m <= 8.0
    )
    change(driven_fleet, ride, "GYM")
    plan = driven_fleet.campus.read(lambda uow: plans.plan_of(uow, shuttle.vehicle_id))
    assert (plan.visits[0].visit_id, plan.visits[0].board) == (visit_id, (ride.ride_id,))
    for _ in range(5):
        driven_fleet.step()
    assert driven_fleet.ride(ride.ride_id).state in (RideState.BOARDING, RideState.ABOARD)


def test_a_destination_that_is_reached_only_after_closing_is_refused(fleet: FakeFleet) -> None:
    hours = (Hours(8 * 3600, 8 * 3600 + 1500),)
    pattern = ServicePattern("snow-lion", "rides", "rides", tuple(range(7)), hours=hours)
    fleet.campus.do(lambda uow: service.save_pattern(uow, pattern, "ann"))
    ride = fleet.book("NN7", "NN20")
    assert ride.state is RideState.ASSIGNED
    with pytest.raises((NoService, DestinationRefused), match=r"closes at 08:25|too long"):
        change(fleet, ride, "C1")
    assert fleet.ride(ride.ride_id) == ride


def test_who_cancels_while_riding_is_let_out_at_the_next_stop(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C1")
    until(driven_fleet, ride, RideState.ABOARD)
    out = cancel(driven_fleet, ride)
    assert (out.state, out.let_out, out.first_to_stop) == (RideState.ABOARD, True, "C1")
    assert out.to_stop != "C1"
    assert cancel(driven_fleet, ride) == out
    driven_fleet.run_until_idle(6000.0)
    done = driven_fleet.ride(ride.ride_id)
    assert (done.state, done.left_early) == (RideState.COMPLETED, True)
    assert done.ended_at is not None
    assert ride.arrival_eta is not None
    assert done.ended_at < ride.arrival_eta
    assert "ride.let_out" in events(driven_fleet)


def test_a_cancellation_from_before_boarding_lets_nobody_out(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C1")
    until(driven_fleet, ride, RideState.ABOARD)
    before = driven_fleet.ride(ride.ride_id)
    with pytest.raises(RideAlreadyAboard, match="not cancelled"):
        driven_fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "passenger", unless_aboard=True))
    assert driven_fleet.ride(ride.ride_id) == before


def test_who_changed_their_mind_may_ride_on(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C1")
    until(driven_fleet, ride, RideState.ABOARD)
    cancel(driven_fleet, ride)
    on = change(driven_fleet, ride, "C1")
    assert (on.let_out, on.first_to_stop, on.to_stop) == (False, None, "C1")
    driven_fleet.run_until_idle(6000.0)
    assert not driven_fleet.ride(ride.ride_id).left_early


def test_the_present_destination_is_no_change_and_leaves_no_record(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    assert change(fleet, ride, "C6") == ride
    assert "ride.destination_changed" not in events(fleet)


def test_riders_change_their_destination_though_the_road_behind_them_is_closed(
    driven_fleet: FakeFleet,
) -> None:
    fleet = driven_fleet
    waiting, riding = fleet.book("NN20", "C1"), fleet.book("NN20", "C6")
    until(fleet, riding, RideState.ABOARD)
    stop = fleet.network.stops["NN20"]
    fleet.run_until(lambda: shuttle_of(fleet, riding).place.lane_id != stop.lane_id)
    fleet.campus.do(lambda uow: closures.close(uow, CloseRoad((stop.lane_id,)), "ann"))
    assert change(fleet, riding, "GYM").to_stop == "GYM"
    late = fleet.ride(waiting.ride_id)
    if late.state is RideState.ASSIGNED:
        with pytest.raises(DestinationRefused):
            change(fleet, late, "GYM")


@pytest.mark.parametrize("state", [RideState.ASSIGNED, RideState.ABOARD])
def test_the_new_latest_arrival_has_the_slack_of_a_booking_made_now(
    driven_fleet: FakeFleet, state: RideState
) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6")
    until(fleet, ride, state)
    changed = change(fleet, ride, "GYM")
    assert changed.promise is not None
    assert changed.arrival_eta is not None
    assert changed.pickup_eta is not None
    now_s = seconds(fleet.campus.clock.now())
    begun_s = now_s if state is RideState.ABOARD else seconds(changed.pickup_eta)
    terms = fleet.campus.read(lambda uow: uow.roads().promise_rules(uow.rules))
    expected_s = terms.arrive_by_s(begun_s, seconds(changed.arrival_eta), now_s)
    assert seconds(changed.promise.arrive_by) - expected_s == pytest.approx(0.0, abs=1e-3)


def test_a_change_after_which_the_shuttle_would_have_nowhere_to_rest_is_refused(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    fleet.leave_homeless(ride.vehicle_id or "")
    with pytest.raises(DestinationRefused) as refused:
        change(fleet, ride, "GYM")
    assert refused.value.rule == "no_vehicle_free"
    assert fleet.ride(ride.ride_id) == ride
