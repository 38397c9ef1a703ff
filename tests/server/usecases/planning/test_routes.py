"""A decided route as a plan: what is told to riders, when the shuttle leaves, and where it rests."""

from dataclasses import replace
from datetime import timedelta

from server.dispatch.problem import Call, CallTime, VehicleRoute
from server.domain.planning.plans import Plan, PlannedVisit
from server.domain.rides.rides import Ride, RideState
from server.usecases.fleet import departures
from server.usecases.planning import plans
from server.usecases.planning.routes import differs_from_plan, refresh_times, vehicles_with_ride
from server.usecases.planning.snapshot import seconds, take_snapshot
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides import rides
from server.usecases.roads.resting import resting_place_for
from server.usecases.roads.section_reservations import SectionReservations
from tests.server.usecases.fake_fleet import FakeFleet


def plan_of(fleet: FakeFleet, ride: Ride) -> Plan:
    return fleet.campus.read(lambda uow: plans.plan_of(uow, ride.vehicle_id or ""))


def a_visit(name: str = "v", **changes: object) -> PlannedVisit:
    return replace(PlannedVisit(name, "stop", "C6", "east-4", 10.0, ("ann",)), **changes)  # type: ignore[arg-type]


def a_route(*calls: Call) -> VehicleRoute:
    return VehicleRoute("shuttle-1", calls, tuple(CallTime(0.0, 0.0) for _ in calls))


def test_a_route_is_news_when_its_stops_their_order_or_their_riders_differ() -> None:
    rest = PlannedVisit("rest", "rest", "", "l", 1.0)
    plan = Plan("c", "shuttle-1", 1, (a_visit("v"), rest, a_visit("w", board=(), alight=("ann",))))
    same = Call(3, ("ann",), (), 15.0, call_id="v"), Call(4, (), ("ann",), 15.0, call_id="w")
    assert not differs_from_plan(plan, a_route(*same))
    assert differs_from_plan(plan, a_route(*reversed(same)))
    assert differs_from_plan(plan, a_route(same[0]))
    assert differs_from_plan(plan, a_route(replace(same[0], board=("ann", "bob")), same[1]))
    assert differs_from_plan(plan, a_route(replace(same[0], alight=("bob",)), same[1]))
    assert differs_from_plan(plan, a_route(replace(same[0], call_id=""), same[1]))


def test_doors_close_no_sooner_than_the_promised_window_opens(driven_fleet: FakeFleet) -> None:
    later = driven_fleet.campus.clock.now() + timedelta(minutes=40)
    ride = driven_fleet.book("NN20", "C6", earliest=later)
    assert ride.promise is not None
    board = next(visit for visit in plan_of(driven_fleet, ride).visits if visit.board)
    assert board.not_before == ride.promise.pickup_from + timedelta(seconds=board.dwell_s)
    alight = next(visit for visit in plan_of(driven_fleet, ride).visits if visit.alight)
    assert alight.not_before is None


def test_riders_are_told_when_their_shuttle_comes_but_never_a_time_before_their_window(
    driven_fleet: FakeFleet,
) -> None:
    later = driven_fleet.campus.clock.now() + timedelta(minutes=40)
    ride = driven_fleet.book("NN20", "C6", earliest=later)
    assert ride.promise is not None
    assert ride.pickup_eta is not None
    assert ride.pickup_eta >= ride.promise.pickup_from
    visits = plan_of(driven_fleet, ride).visits
    assert next(visit for visit in visits if visit.alight).eta == ride.arrival_eta


def test_between_a_ride_of_now_and_one_of_much_later_the_shuttle_rests(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    fleet.shuttles[1].hold()
    now = fleet.book("NN20", "C6")
    later = fleet.book("NN20", "C6", earliest=fleet.campus.clock.now() + timedelta(hours=3))
    assert now.vehicle_id == later.vehicle_id
    visits = plan_of(fleet, now).visits
    made = [(visit.kind, visit.board + visit.alight) for visit in visits]
    assert made == [
        ("stop", (now.ride_id,)),
        ("stop", (now.ride_id,)),
        ("rest", ()),
        ("stop", (later.ride_id,)),
        ("stop", (later.ride_id,)),
    ]
    assert plan_of(fleet, now).ordered == visits[:3]


def test_a_shuttle_whose_ride_of_now_is_cancelled_before_it_leaves_rests_until_the_one_of_much_later(
    driven_fleet: FakeFleet,
) -> None:
    """It would stand at the stop for hours, in the way of all who come behind it."""
    fleet = driven_fleet
    fleet.shuttles[1].hold()
    begins = fleet.campus.clock.now() + timedelta(hours=3)
    homes = fleet.campus.read(
        lambda uow: {plan.vehicle_id: plan.resting_place_id for plan in uow.plans.all()}
    )
    later = fleet.book("1B", "C6", earliest=begins)
    now = fleet.book("NN20", "C6")
    assert now.vehicle_id == later.vehicle_id
    fleet.campus.do(lambda uow: rides.cancel(uow, now.ride_id, "passenger"))
    plan = plan_of(fleet, later)
    assert [visit.kind for visit in plan.ordered] == ["rest"]
    assert plan.resting_place_id == homes[plan.vehicle_id]
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == later.vehicle_id)
    fleet.run_until(
        lambda: "under_way" in [shuttle.states.get(visit.visit_id) for visit in stops_of(fleet, later)],
        limit_s=4 * 3600.0,
    )
    assert begins - fleet.campus.clock.now() < timedelta(minutes=15)


def stops_of(fleet: FakeFleet, ride: Ride) -> list[PlannedVisit]:
    return [visit for visit in plan_of(fleet, ride).visits if visit.kind == "stop"]


def test_it_rests_in_between_as_soon_as_there_is_time_for_the_way_by_the_resting_place(
    driven_fleet: FakeFleet,
) -> None:
    """With less time it would be late at 1B, which is ahead while all resting places are behind."""
    fleet = driven_fleet
    fleet.shuttles[1].hold()
    now = fleet.book("NN20", "GYM")
    fleet.run_until(lambda: fleet.ride(now.ride_id).state is RideState.ABOARD)
    fleet.campus.do(plans.refresh_expected)
    seen = set()
    for spare_s in range(-60, 65, 8):
        alight = plan_of(fleet, now).visits[0]
        assert alight.eta is not None
        leaves, dwell_s = alight.eta + timedelta(seconds=alight.dwell_s), alight.dwell_s
        early_s, factor = fleet.campus.read(
            lambda uow, at=leaves: (uow.rules.early_s(timed=False), uow.travel_time_factor_at(at))  # type: ignore[misc]
        )
        plan = plan_of(fleet, now)
        way_s = fleet.campus.read(lambda uow, p=plan, v=alight: by_rest_s(uow, p, v))  # type: ignore[misc]
        boards = leaves + timedelta(seconds=factor * way_s + early_s + dwell_s + spare_s)
        later = fleet.book("1B", "NN20", earliest=boards - timedelta(seconds=dwell_s))
        visits = plan_of(fleet, later).visits
        assert next(v for v in visits if v.board).not_before == boards
        kinds = [visit.kind for visit in visits]
        assert (kinds == ["stop", "rest", "stop", "stop"]) is (spare_s >= 0), spare_s
        seen.add(spare_s >= 0)
        fleet.campus.do(lambda uow, r=later: rides.cancel(uow, r.ride_id, "passenger"))  # type: ignore[misc]
    assert seen == {True, False}


def by_rest_s(uow: UnitOfWork, plan: Plan, last: PlannedVisit) -> float:
    """The way from a visit to 1B by way of a resting place."""
    stop = uow.network().stops["1B"]
    onward = PlannedVisit("v", "stop", "1B", stop.lane_id, stop.s_m)
    return resting_place_for(uow, plan, (last.lane_id, last.s_m), onward, SectionReservations(uow))[1]


def test_every_plan_ends_its_order_at_a_resting_place_of_its_own(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    for pair in (("NN20", "C6"), ("C6", "GYM"), ("NN7", "C1")):
        fleet.book(*pair)
    found = fleet.campus.read(lambda uow: uow.plans.all())
    for plan in found:
        if plan.ordered:
            assert plan.ordered[-1].kind == "rest"
    places = [plan.resting_place_id for plan in found]
    assert len(set(places)) == len(places)


def test_times_that_hardly_move_are_not_told_again_and_others_are_without_a_new_plan(
    driven_fleet: FakeFleet,
) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6")
    before = plan_of(fleet, ride)

    def later_by(late_s: float) -> Ride:
        def work(uow: UnitOfWork) -> None:
            snapshot = take_snapshot(uow)
            calls = next(v for v in snapshot.problem.vehicles if v.vehicle_id == ride.vehicle_id).calls
            times = []
            for call in calls:
                visit = before.visit(call.call_id)
                assert visit is not None
                assert visit.eta is not None
                times.append(CallTime(seconds(visit.eta) + late_s, seconds(visit.eta) + late_s + 15.0))
            refresh_times(uow, snapshot, VehicleRoute(ride.vehicle_id or "", calls, tuple(times)))

        fleet.campus.do(work)
        return fleet.ride(ride.ride_id)

    assert later_by(9.0).arrival_eta == ride.arrival_eta
    moved = later_by(60.0)
    assert ride.arrival_eta is not None
    assert moved.arrival_eta == ride.arrival_eta + timedelta(seconds=60)
    assert plan_of(fleet, ride).version == before.version


def test_a_departure_keeps_the_times_of_its_calls_and_is_given_to_the_shuttle(
    driven_fleet: FakeFleet,
) -> None:
    campus = driven_fleet.campus
    campus.clock.advance(-1200.0)
    assigned = campus.do(departures.plan_departures)
    first = campus.read(lambda uow: uow.departures.get(assigned[0].departure_id))
    assert first is not None
    assert first.vehicle_id is not None
    plan = campus.read(lambda uow: plans.plan_of(uow, first.vehicle_id or ""))
    made = [visit for visit in plan.visits if visit.departure_id == first.departure_id]
    assert [visit.not_before for visit in made] == [call.leave_at for call in first.calls]
    assert [visit.call for visit in made] == list(range(len(first.calls)))
    assert all(visit.latest is not None for visit in made)


def test_a_ride_moved_to_another_shuttle_is_named_by_that_ones_plan_alone(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6")
    lost = next(s for s in fleet.shuttles if s.vehicle_id == ride.vehicle_id)
    other = next(s for s in fleet.shuttles if s.vehicle_id != ride.vehicle_id)
    lost.disconnect()
    lost.mode = "fault"
    fleet.run_until(lambda: fleet.ride(ride.ride_id).vehicle_id == other.vehicle_id, 600.0)
    found = fleet.campus.read(lambda uow: vehicles_with_ride(uow.plans.all(), ride.ride_id))
    assert found == [other.vehicle_id]
    assert fleet.ride(ride.ride_id).state is RideState.ASSIGNED
