"""Cheapest insertion against all insertions, and what every solution must keep."""

import itertools
from dataclasses import replace

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from server.dispatch.insertion import Route, cheapest_chain, cheapest_insertion, evaluated, without_request
from server.dispatch.problem import Call, Chain, Problem, Request, VehicleState
from server.dispatch.schedule import Broken
from server.dispatch.solve import Budget, Solution, solve
from tests.server.dispatch.problems import problems

BOUNDED = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
RNG = np.random.default_rng(0)


def present(problem: Problem) -> list[Route]:
    routes = []
    for vehicle in problem.vehicles:
        route = evaluated(problem, vehicle, vehicle.calls)
        assert isinstance(route, Route)
        routes.append(route)
    return routes


def every_insertion(calls: tuple[Call, ...], request: Request, dwell_s: float) -> list[tuple[Call, ...]]:
    """By brute force: both new calls anywhere in order, then any of them merged into an equal neighbour."""
    pickup = Call(request.pickup, (request.request_id,), (), dwell_s)
    dropoff = Call(request.dropoff, (), (request.request_id,), dwell_s)
    found = []
    for i, j in itertools.combinations_with_replacement(range(len(calls) + 1), 2):
        whole = [*calls[:i], pickup, *calls[i:j], dropoff, *calls[j:]]
        found += merged(whole, i, j + 1)
    return found


def merged(calls: list[Call], i: int, j: int) -> list[tuple[Call, ...]]:
    """The calls as they are, and with one or both of these joined to the next call at the same place."""
    found = []
    for joins in ((), (j,), (i,), (i, j)):
        trial: list[Call] | None = list(calls)
        for index in sorted(joins, reverse=True):
            trial = joined(trial, index) if trial is not None else None
        if trial is not None:
            found.append(tuple(trial))
    return found


def joined(calls: list[Call], index: int) -> list[Call] | None:
    if index + 1 >= len(calls) or calls[index].place != calls[index + 1].place:
        return None
    one, two = calls[index], calls[index + 1]
    both = replace(
        two,
        board=two.board + one.board,
        alight=two.alight + one.alight,
        dwell_s=max(one.dwell_s, two.dwell_s),
    )
    return [*calls[:index], both, *calls[index + 2 :]]


@BOUNDED
@given(problems(vehicles=2, wanted=4))
def test_the_cheapest_insertion_equals_the_best_of_all_insertions(problem: Problem) -> None:
    *earlier, last = problem.open_requests
    done = solve(replace(problem, open_requests=tuple(earlier)), Budget(), RNG)
    vehicles = tuple(
        replace(vehicle, calls=route.calls)
        for vehicle, route in zip(problem.vehicles, done.routes, strict=True)
    )
    loaded = replace(problem, vehicles=vehicles)
    routes, request = present(loaded), problem.requests[last]
    found = cheapest_insertion(loaded, routes, request)
    best = min(
        (
            route.cost - before.cost
            for vehicle, before in zip(vehicles, routes, strict=True)
            for calls in every_insertion(before.calls, request, problem.dwell_s)
            if isinstance(route := evaluated(loaded, vehicle, calls), Route)
        ),
        default=None,
    )
    assert (found is None) == (best is None)
    if found is not None and best is not None:
        assert abs(found.extra_cost - best) < 1e-6


def require_sound(problem: Problem, solution: Solution) -> None:
    """Every rule looked at again, by other means than the schedule's own."""
    carried: list[str] = []
    for vehicle, route in zip(problem.vehicles, solution.routes, strict=True):
        clock_s, place, inside, left = vehicle.ready_s, vehicle.start, list(vehicle.aboard), {}
        for call, time in zip(route.calls, route.times, strict=True):
            assert abs(time.arrive_s - (clock_s + vehicle.times[place, call.place])) < 1e-6
            assert time.leave_s >= time.arrive_s + call.dwell_s - 1e-6
            for name in call.alight:
                inside.remove(name)
                request = problem.requests[name]
                assert request.dropoff == call.place
                assert time.arrive_s <= request.arrive_by_s + 1e-5
                assert time.arrive_s - left[name] <= request.ride_s_max + 1e-5
            for name in call.board:
                inside.append(name)
                carried.append(name)
                request = problem.requests[name]
                left[name] = time.leave_s
                assert request.pickup == call.place
                assert time.arrive_s <= request.pickup_to_s + 1e-5
                assert time.leave_s >= request.pickup_from_s + call.dwell_s - 1e-6
            assert sum(problem.requests[name].party for name in inside) <= vehicle.seats
            assert sum(problem.requests[name].wheelchairs for name in inside) <= vehicle.wheelchair_places
            clock_s, place = time.leave_s, call.place
        assert not inside
    assert sorted([*carried, *solution.refused]) == sorted(problem.open_requests)


@BOUNDED
@given(problems(vehicles=2, wanted=6), st.integers(0, 40))
def test_every_request_is_carried_within_all_rules_or_refused(problem: Problem, moves: int) -> None:
    require_sound(problem, solve(problem, Budget(moves), np.random.default_rng(1)))


@BOUNDED
@given(problems(vehicles=2, wanted=6), st.integers(1, 40))
def test_improvement_never_costs_more_and_never_drops_anybody(problem: Problem, moves: int) -> None:
    plain = solve(problem, Budget(), np.random.default_rng(1))
    better = solve(problem, Budget(moves), np.random.default_rng(1))
    assert better.cost <= plain.cost + 1e-6
    assert better.refused == plain.refused
    assert better.tried <= moves


@BOUNDED
@given(problems(vehicles=2, wanted=5))
def test_the_same_problem_budget_and_seed_give_the_same_answer(problem: Problem) -> None:
    first, second = (solve(problem, Budget(20), np.random.default_rng(7)) for _ in range(2))
    assert first == second


@BOUNDED
@given(problems(vehicles=1, wanted=4))
def test_what_is_promised_stays_in_its_windows_when_others_come_in(problem: Problem) -> None:
    first, *others = problem.open_requests
    alone = solve(replace(problem, open_requests=(first,)), Budget(), RNG)
    vehicles = (replace(problem.vehicles[0], calls=alone.routes[0].calls),)
    if first in alone.refused:
        return
    together = solve(
        replace(problem, vehicles=vehicles, open_requests=tuple(others)), Budget(30), np.random.default_rng(2)
    )
    assert any(first in call.board for route in together.routes for call in route.calls)
    require_sound(problem, replace(together, refused=together.refused))


def line(*places: int) -> VehicleState:
    """A vehicle at place 0 of a straight road with a place every 100 s."""
    times = 100.0 * np.abs(np.arange(6)[:, None] - np.arange(6)[None, :])
    calls = tuple(Call(place, fixed=True, dwell_s=10.0) for place in places)
    return VehicleState("v", 0, 0.0, 6, 0, times, calls=calls)


def test_a_departure_keeps_its_order_and_its_times() -> None:
    chain = Chain(
        "trip",
        tuple(
            Call(p, dwell_s=10.0, leave_from_s=t, arrive_by_s=t + 50.0, fixed=True)
            for p, t in ((1, 300.0), (3, 700.0))
        ),
    )
    problem = Problem((line(2),), {}, open_chains=(chain,))
    route = solve(problem, Budget(), RNG).routes[0]
    assert [call.place for call in route.calls] in ([2, 1, 3], [1, 2, 3], [1, 3, 2])
    timed = {call.place: time for call, time in zip(route.calls, route.times, strict=True)}
    assert timed[1].leave_s >= 300.0
    assert timed[1].arrive_s <= 350.0
    assert timed[3].leave_s >= 700.0


def test_a_departure_that_nobody_can_make_in_time_is_refused() -> None:
    chain = Chain("trip", (Call(5, dwell_s=10.0, leave_from_s=100.0, arrive_by_s=150.0, fixed=True),))
    problem = Problem((line(),), {}, open_chains=(chain,))
    assert solve(problem, Budget(), RNG).refused == {"trip": "departure"}
    assert cheapest_chain(problem, present(problem), chain) is None


def test_a_call_under_way_is_never_preceded_nor_joined() -> None:
    vehicle = replace(line(1, 4), locked=1)
    request = Request("r", 1, 3, 1, 0, 0.0, 9000.0, 9000.0)
    problem = Problem((vehicle,), {"r": request}, ("r",), dwell_s=10.0)
    calls = solve(problem, Budget(), RNG).routes[0].calls
    assert calls[0] == vehicle.calls[0]


def test_taking_a_request_out_drops_its_calls_but_no_fixed_ones() -> None:
    calls = (Call(1, ("a",), ()), Call(2, ("b",), ("a",)), Call(3, (), ("b",), fixed=True))
    assert without_request(calls, "b") == (
        Call(1, ("a",), ()),
        Call(2, (), ("a",)),
        Call(3, (), (), fixed=True),
    )


def test_a_vehicle_that_accepts_nothing_gets_nothing() -> None:
    request = Request("r", 1, 3, 1, 0, 0.0, 9000.0, 9000.0)
    problem = Problem((replace(line(), accepts=False),), {"r": request}, ("r",), dwell_s=10.0)
    assert solve(problem, Budget(), RNG).refused == {"r": "no_vehicle_free"}
    assert not isinstance(evaluated(problem, problem.vehicles[0], ()), Broken)
