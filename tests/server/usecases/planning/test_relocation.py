"""Idle shuttles wait where the past weeks' riders came from."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime, timedelta

import pytest

from server.dispatch.demand import FREE_DAY, WORKDAY
from server.domain.planning.plans import Plan
from server.domain.rides.rides import Ride, RideState
from server.domain.rules import FleetRules
from server.domain.service.service import ServiceException
from server.loops.dispatcher import RELOCATION_PERIODS, Dispatcher
from server.loops.solver import InlineSolver
from server.usecases.planning import relocation
from server.usecases.planning.relocation import Relocation
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fresh_database import fresh_database
from tests.server.usecases.small_campus import small_campus

MONDAY_EIGHT = datetime.fromisoformat("2026-11-23T08:00:00+00:00")
# From a resting place on side 1 the next stops are 2, 3, 0 and 1; from side 3 they are 0, 1, 2 and 3.
WANTED = "stop-2"


@pytest.fixture
def fleet() -> Iterator[FakeFleet]:
    made = a_fleet(FleetRules())
    yield made
    made.campus.close()


def a_fleet(rules: FleetRules, count: int = 1) -> FakeFleet:
    road_map = small_campus()
    campus = CampusUnderTest(road_map, rules, engine=fresh_database(), now=MONDAY_EIGHT)
    return FakeFleet(campus, road_map, count).start()


def remember(fleet: FakeFleet, days: int, a_day: int, stop_id: str = WANTED, hour: int = 8) -> None:
    """So many rides from the stop on each of the last days, most of them refused."""
    made = fleet.campus.ids

    def work(uow: UnitOfWork) -> None:
        for back in range(1, days + 1):
            for number in range(a_day):
                at = MONDAY_EIGHT.replace(hour=hour) - timedelta(days=back) + timedelta(minutes=number)
                state = RideState.REFUSED if number % 3 else RideState.COMPLETED
                ride_id = made.new_id("past")
                uow.rides.add(
                    Ride(
                        uow.campus_id, ride_id, "AAAAAA", "key", state, stop_id, "stop-1",
                        1, 0, at, at, "passenger", ended_at=at,
                    )
                )  # fmt: skip

    fleet.campus.do(work)


def look(fleet: FakeFleet) -> str | None:
    return look_with(fleet, fleet.campus.read(relocation.learn_demand))


def look_with(fleet: FakeFleet, demand: relocation.Demand) -> str | None:
    """The vehicle that sets out."""
    move = fleet.campus.read(lambda uow: relocation.best_relocation(uow, demand))
    if move is None or not fleet.campus.do(lambda uow: relocation.relocate(uow, move)):
        return None
    return move.vehicle_id


def place_of(fleet: FakeFleet, number: int = 0) -> str:
    plan = fleet.campus.read(lambda uow: uow.plans.get(fleet.shuttles[number].vehicle_id))
    assert plan is not None
    return plan.resting_place_id


def test_a_shuttle_goes_to_where_riders_are_expected_and_stays_there(fleet: FakeFleet) -> None:
    assert place_of(fleet) == "bay-1"
    remember(fleet, 20, 6, "stop-0")
    assert look(fleet) == "shuttle-1"
    plan = fleet.campus.read(lambda uow: uow.plans.get("shuttle-1"))
    assert plan is not None
    assert [(visit.kind, visit.why) for visit in plan.visits] == [("rest", "demand")]
    assert look(fleet) is None
    fleet.step()
    fleet.run_until_idle(600.0)
    assert fleet.shuttles[0].place.lane_id == "bay-3"
    for _ in range(5):
        assert look(fleet) is None
        fleet.step()
    assert fleet.book("stop-0", "stop-1").state is RideState.ASSIGNED
    fleet.run_until_idle(1000.0)


def test_with_no_past_or_hardly_any_nobody_wanders(fleet: FakeFleet) -> None:
    assert look(fleet) is None
    remember(fleet, 1, 1, "stop-0")
    assert look(fleet) is None
    for stop in range(4):
        fleet.book(f"stop-{stop}", f"stop-{(stop + 1) % 4}")
    fleet.run_until_idle(2000.0)
    assert look(fleet) is None


def test_a_place_that_is_as_good_is_not_worth_the_way(fleet: FakeFleet) -> None:
    for stop in range(4):
        remember(fleet, 20, 4, f"stop-{stop}")
    assert look(fleet) is None


def test_it_can_be_turned_off() -> None:
    fleet = a_fleet(FleetRules(relocates=False))
    remember(fleet, 20, 6, "stop-0")
    assert look(fleet) is None
    fleet.campus.close()


@pytest.mark.parametrize("why", ["weekend", "hour", "holiday"])
def test_what_is_expected_depends_on_the_hour_and_the_kind_of_day(fleet: FakeFleet, why: str) -> None:
    remember(fleet, 20, 6, "stop-0")
    demand = fleet.campus.read(relocation.learn_demand)
    if why == "hour":
        fleet.campus.clock.advance(5 * 3600.0)
    elif why == "weekend":
        fleet.campus.clock.advance(5 * 86400.0)
        rates = demand.rates.copy()
        rates[1] = 0.0
        demand = replace(demand, rates=rates)
    else:
        today = MONDAY_EIGHT.date()
        fleet.campus.do(
            lambda uow: uow.service.save_exception(ServiceException(uow.campus_id, today, "", False))
        )
        rates = demand.rates.copy()
        rates[1] = 0.0
        demand = replace(demand, rates=rates)
    assert look_with(fleet, demand) is None


def test_a_busy_a_held_and_a_charging_shuttle_stay(fleet: FakeFleet) -> None:
    remember(fleet, 20, 6, "stop-0")
    (shuttle,) = fleet.shuttles
    shuttle.hold()
    assert look(fleet) is None
    shuttle.recover()
    shuttle.battery_ratio = 0.3
    shuttle.report()
    assert look(fleet) is None
    shuttle.battery_ratio = 0.9
    shuttle.report()
    fleet.book("stop-2", "stop-3")
    assert look(fleet) is None
    fleet.run_until_idle(1000.0)
    assert look(fleet) in ("shuttle-1", None)


def test_a_place_that_is_taken_is_left_to_its_owner() -> None:
    fleet = a_fleet(FleetRules(), count=2)
    remember(fleet, 20, 6, "stop-0")
    assert look(fleet) is None
    assert [place_of(fleet, 0), place_of(fleet, 1)] == ["bay-1", "bay-3"]
    fleet.campus.close()


def test_what_was_learned_is_learned_anew_every_hour(fleet: FakeFleet) -> None:
    demand = fleet.campus.read(relocation.learn_demand)
    assert not fleet.campus.read(lambda uow: relocation.is_stale(uow, demand))
    fleet.campus.clock.advance(3600.0)
    assert fleet.campus.read(lambda uow: relocation.is_stale(uow, demand))


def test_a_proposal_that_was_overtaken_is_dropped(fleet: FakeFleet) -> None:
    remember(fleet, 20, 6, "stop-0")
    demand = fleet.campus.read(relocation.learn_demand)
    move = fleet.campus.read(lambda uow: relocation.best_relocation(uow, demand))
    assert move is not None
    ride = fleet.book("stop-2", "stop-3")
    assert not fleet.campus.do(lambda uow: relocation.relocate(uow, move))
    fleet.run_until_idle(1000.0)
    assert fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_a_shuttle_that_has_never_connected_and_one_that_is_unknown_are_sent_nowhere(
    fleet: FakeFleet,
) -> None:
    fleet.campus.enrol("shuttle-9")
    place_id = fleet.campus.read(lambda uow: uow.network().road_map.resting_places[0].place_id)
    for vehicle_id in ("shuttle-9", "nobody"):
        move = Relocation(vehicle_id, place_id, 0, 60.0)
        assert not fleet.campus.do(lambda uow, move=move: relocation.relocate(uow, move))  # type: ignore[misc]


def test_the_dispatcher_sends_it() -> None:
    fleet = a_fleet(FleetRules())
    campus = fleet.campus
    remember(fleet, 20, 6, "stop-0")
    dispatcher = Dispatcher(campus.transactions, campus.bus, InlineSolver(), campus.ids, "small", 0)
    for _ in range(RELOCATION_PERIODS):
        campus.clock.advance(1.0)
        campus.wait_for(dispatcher.run_once())
    assert place_of(fleet) == "bay-3"
    campus.close()


def a_morning(relocates: bool) -> float:
    """Mean seconds from a request to the boarding, on a morning like those of the past weeks."""
    fleet = a_fleet(FleetRules(relocates=relocates))
    remember(fleet, 20, 6)
    demand = fleet.campus.read(relocation.learn_demand)
    for _ in range(6):
        due = fleet.campus.clock.now() + timedelta(seconds=600.0)
        fleet.book(WANTED, "stop-1")
        while fleet.campus.clock.now() < due:
            fleet.step()
            if fleet.beats % 5 == 0:
                look_with(fleet, demand)
    waits = [
        (ride.boarded_at - ride.requested_at).total_seconds()
        for ride in fleet.rides()
        if ride.boarded_at is not None and ride.requested_at >= MONDAY_EIGHT
    ]
    assert len(waits) == 6
    fleet.campus.close()
    return sum(waits) / len(waits)


def test_riders_wait_less_than_where_everybody_stays_put() -> None:
    assert a_morning(relocates=True) < 0.75 * a_morning(relocates=False)


@pytest.mark.parametrize(("days", "kind"), [(4, "workday"), (5, "free day"), (6, "free day")])
def test_friday_is_a_workday_and_saturday_is_none(fleet: FakeFleet, days: int, kind: str) -> None:
    remember(fleet, 20, 6, "stop-0")
    demand = fleet.campus.read(relocation.learn_demand)
    rates = demand.rates.copy()
    rates[FREE_DAY if kind == "workday" else WORKDAY] = 0.0
    fleet.campus.clock.advance(days * 86400.0)
    assert look_with(fleet, replace(demand, rates=rates)) == "shuttle-1"


@pytest.mark.parametrize(("early_s", "goes"), [(0.0, True), (1.0, False)])
def test_it_sets_out_for_the_hour_in_which_it_arrives(fleet: FakeFleet, early_s: float, goes: bool) -> None:
    remember(fleet, 20, 6, "stop-0")
    demand = fleet.campus.read(relocation.learn_demand)
    rates = demand.rates.copy()
    rates[:, :8] = rates[:, 9:] = 0.0
    fleet.campus.clock.advance(-fleet.campus.rules.relocation_ahead_s - early_s)
    assert (look_with(fleet, replace(demand, rates=rates)) == "shuttle-1") is goes


@pytest.mark.parametrize(("spare", "goes"), [(0.0, True), (-0.01, False)])
def test_it_goes_with_enough_charge_to_take_rides_there(fleet: FakeFleet, spare: float, goes: bool) -> None:
    remember(fleet, 20, 6, "stop-0")
    fleet.shuttles[0].battery_ratio = fleet.campus.rules.battery_accept_ratio + spare
    fleet.shuttles[0].report()
    assert (look(fleet) == "shuttle-1") is goes


def test_a_place_on_which_another_shuttle_still_stands_is_not_free() -> None:
    fleet = a_fleet(FleetRules(), count=2)
    remember(fleet, 20, 6, "stop-0")
    plan = fleet.campus.read(lambda uow: uow.plans.get("shuttle-2"))
    assert plan is not None
    given_up = replace(plan, version=plan.version + 1, resting_place_id="")
    fleet.campus.do(lambda uow: uow.plans.save(given_up, plan.version))
    assert look(fleet) is None
    fleet.campus.close()


@pytest.mark.parametrize("why", ["held", "no place free any more"])
def test_what_has_changed_without_the_plan_overtakes_a_proposal_as_well(fleet: FakeFleet, why: str) -> None:
    remember(fleet, 20, 6, "stop-0")
    demand = fleet.campus.read(relocation.learn_demand)
    move = fleet.campus.read(lambda uow: relocation.best_relocation(uow, demand))
    assert move is not None
    if why == "held":
        fleet.shuttles[0].hold()
    else:
        fleet.campus.enrol("shuttle-2")
        there = Plan(fleet.campus.read(lambda uow: uow.campus_id), "shuttle-2", 1, (), move.place_id)
        fleet.campus.do(lambda uow: uow.plans.save(there, 0))
    assert not fleet.campus.do(lambda uow: relocation.relocate(uow, move))
