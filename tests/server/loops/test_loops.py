"""The standing tasks on a virtual loop, over inline transactions."""

import asyncio
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace

import pytest

from server.dispatch.problem import Problem
from server.dispatch.solve import Budget, Solution
from server.domain.errors import LeaseLost
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import RideState
from server.loops import dispatcher
from server.loops.departures import DepartureScheduler
from server.loops.dispatcher import LEASE, LEASE_S, Dispatcher
from server.loops.retention import RetentionLoop
from server.loops.silence import SilenceMonitor
from server.loops.solver import InlineSolver, ProcessSolver
from server.usecases.planning import plans
from server.usecases.planning.decisions import SearchSettings
from server.usecases.planning.snapshot import take_snapshot
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map


@pytest.fixture
def fleet() -> Iterator[FakeFleet]:
    campus = CampusUnderTest(shipped_map("snow-lion"))
    yield FakeFleet(campus, shipped_map("snow-lion"), 3).start()
    campus.close()


def a_dispatcher(fleet: FakeFleet, slices: int = 2) -> Dispatcher:
    campus = fleet.campus
    return Dispatcher(campus.transactions, campus.bus, InlineSolver(), campus.ids, "snow-lion", slices)


def test_the_dispatcher_finds_another_shuttle_for_rides_that_lost_theirs(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    fleet.campus.do(lambda uow: plans.release_waiting(uow, ride.vehicle_id or ""))
    assert fleet.ride(ride.ride_id).state is RideState.REQUESTED
    fleet.campus.wait_for(a_dispatcher(fleet).run_once())
    assert fleet.ride(ride.ride_id).state is RideState.ASSIGNED


def test_only_the_holder_of_the_lease_dispatches_and_a_fenced_one_stops(fleet: FakeFleet) -> None:
    campus = fleet.campus
    first, second = a_dispatcher(fleet), a_dispatcher(fleet)
    campus.wait_for(first.run_once())
    token = campus.read(lambda uow: uow.leases.token(LEASE))
    campus.wait_for(second.run_once())
    assert campus.read(lambda uow: uow.leases.token(LEASE)) == token
    campus.clock.advance(LEASE_S + 1.0)
    campus.wait_for(second.run_once())
    assert campus.read(lambda uow: uow.leases.token(LEASE)) == token + 1
    with pytest.raises(LeaseLost):
        campus.wait_for(first._fenced(lambda uow: uow.now))


def test_improvement_moves_waiting_rides_only_to_where_they_cost_less(fleet: FakeFleet) -> None:
    campus = fleet.campus
    for from_stop, to_stop in (("NN20", "C6"), ("C6", "NN7"), ("GYM", "C1"), ("NN20", "SE13")):
        fleet.book(from_stop, to_stop)
    improvement = campus.read(lambda uow: plans.improvement_of(take_snapshot(uow)))
    assert improvement is not None
    dispatcher = a_dispatcher(fleet, 40)
    for _ in range(5):
        campus.wait_for(dispatcher.run_once())
    rides = fleet.rides()
    assert all(ride.state in (RideState.ASSIGNED, RideState.REFUSED) for ride in rides)
    assert not any(ride.promise_broken for ride in rides)


def test_a_late_improvement_is_dropped(fleet: FakeFleet) -> None:
    campus = fleet.campus
    fleet.book("NN20", "C6")
    improvement = campus.read(lambda uow: plans.improvement_of(take_snapshot(uow)))
    assert improvement is not None
    search = SearchSettings(a_dispatcher(fleet)._budget, 1)
    solution = campus.wait_for(InlineSolver().solve(improvement.problem, search.budget, search.seed))
    fleet.book("NN20", "GYM")
    before = campus.read(lambda uow: uow.plans.all())
    assert campus.do(lambda uow: plans.adopt_improvement(uow, improvement, solution, search)) == ()
    assert campus.read(lambda uow: uow.plans.all()) == before


class CountingSolver(InlineSolver):
    def __init__(self) -> None:
        self.searches = 0

    async def solve(self, problem: Problem, budget: Budget, seed: int) -> Solution:
        self.searches += 1
        return await super().solve(problem, budget, seed)


def test_plans_that_searches_could_not_improve_are_searched_again_when_one_has_changed(
    fleet: FakeFleet,
) -> None:
    campus, solver = fleet.campus, CountingSolver()
    tried = Dispatcher(campus.transactions, campus.bus, solver, campus.ids, "snow-lion", 2)

    def searches_in(periods: int) -> int:
        before = solver.searches
        for _ in range(periods * dispatcher.SLOW_PERIODS):
            campus.wait_for(tried.run_once())
        return solver.searches - before

    fleet.book("NN20", "C6")
    assert searches_in(6) == 2
    fleet.book("GYM", "C6")
    assert searches_in(1) == 1


def test_what_a_child_process_found_is_found_again_inline(fleet: FakeFleet) -> None:
    fleet.book("NN20", "C6")
    improvement = fleet.campus.read(lambda uow: plans.improvement_of(take_snapshot(uow)))
    assert improvement is not None
    budget = a_dispatcher(fleet)._budget

    async def both() -> bool:
        child = ProcessSolver()
        there = await child.solve(improvement.problem, budget, 5)
        as_many = replace(budget, stop_after=there.slices)
        here = await InlineSolver().solve(improvement.problem, as_many, 5)
        child.close()
        return there == here

    assert asyncio.run(both())


def test_silence_departures_and_retention_do_their_work_in_a_beat(fleet: FakeFleet) -> None:
    campus = fleet.campus
    campus.clock.advance(60.0)
    campus.wait_for(SilenceMonitor(campus.transactions).run_once())
    open_now = campus.read(lambda uow: uow.views.incidents())
    assert {incident.kind for incident in open_now} == {IncidentKind.VEHICLE_SILENT}
    campus.wait_for(DepartureScheduler(campus.transactions, "me").run_once())
    campus.wait_for(DepartureScheduler(campus.transactions, "somebody else").run_once())
    assert len(campus.read(lambda uow: uow.views.departures())) > 0
    campus.wait_for(RetentionLoop(campus.transactions).run_once())
    assert campus.read(lambda uow: enrolled_vehicle(uow, "shuttle-1")).placed


def test_a_step_that_fails_keeps_no_other_step_of_the_dispatcher_from_its_work(
    fleet: FakeFleet, monkeypatch: pytest.MonkeyPatch
) -> None:
    def defect(_uow: UnitOfWork) -> None:
        raise ZeroDivisionError("a poisoned row")

    ride = fleet.book("NN20", "C6")
    fleet.campus.do(lambda uow: plans.release_waiting(uow, ride.vehicle_id or ""))
    monkeypatch.setattr(dispatcher, "_EVERY_PERIOD", (defect, *dispatcher._EVERY_PERIOD))
    with pytest.raises(ExceptionGroup) as failed:
        fleet.campus.wait_for(a_dispatcher(fleet).run_once())
    assert [str(error) for error in failed.value.exceptions] == ["a poisoned row"]
    assert fleet.ride(ride.ride_id).state is RideState.ASSIGNED


def test_a_solver_whose_child_was_killed_has_a_new_one_for_the_next_search(fleet: FakeFleet) -> None:
    fleet.book("NN20", "C6")
    improvement = fleet.campus.read(lambda uow: plans.improvement_of(take_snapshot(uow)))
    assert improvement is not None
    budget = a_dispatcher(fleet)._budget

    async def killed_between() -> Solution:
        solver = ProcessSolver()
        await solver.solve(improvement.problem, budget, 5)
        (child,) = solver._pool._processes.values()
        child.kill()
        with pytest.raises(BrokenProcessPool):
            await solver.solve(improvement.problem, budget, 5)
        after = await solver.solve(improvement.problem, budget, 5)
        solver.close()
        return after

    assert asyncio.run(killed_between()).routes
