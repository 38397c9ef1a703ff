"""Cheapest insertion against all insertions, and what every solution must keep."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from server.dispatch.problem import Call, Chain, Problem, Request, VehicleState
from server.dispatch.schedule.schedule import Schedule
from server.dispatch.solve import Budget, Solution, solve
from tests.server.dispatch.problems import problems
from tests.server.dispatch.reference import Broken, every_insertion, route_cost, schedule

BOUNDED = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
SEED = 1


def cost_of(problem: Problem, vehicle: VehicleState, calls: tuple[Call, ...]) -> float | None:
    times = schedule(problem, vehicle, calls)
    return None if isinstance(times, Broken) else route_cost(problem, vehicle, calls, times)


@BOUNDED
@given(problems(vehicles=2, wanted=4))
def test_a_request_is_taken_whenever_some_insertion_keeps_every_rule(problem: Problem) -> None:
    loaded, last, best = with_one_to_come(problem)
    solution = solve(loaded, Budget(), SEED)
    assert best is None or last not in solution.refused or has_travel_time_factors(problem)
    require_sound(loaded, solution)


@BOUNDED
@given(problems(vehicles=2, wanted=4))
def test_no_insertion_is_cheaper_than_the_one_chosen(problem: Problem) -> None:
    """Without ride limits: a pickup put off for one is waiting here, and riding in the reference."""
    patient = {name: replace(r, ride_s_max=math.inf) for name, r in problem.requests.items()}
    loaded, _, best = with_one_to_come(replace(problem, requests=patient))
    route_costs = []
    for vehicle, route in zip(loaded.vehicles, solve(loaded, Budget(), SEED).routes, strict=True):
        costs = cost_of(loaded, vehicle, route.calls), cost_of(loaded, vehicle, vehicle.calls)
        assert costs[0] is not None
        assert costs[1] is not None
        route_costs.append(costs[0] - costs[1])
    assert best is None or sum(route_costs) <= best + 1e-6 or has_travel_time_factors(problem)


def has_travel_time_factors(problem: Problem) -> bool:
    """A visit may then shorten the way, which the quick test does not expect: it may miss such a place."""
    return any(request.travel_time_factor != 1.0 for request in problem.requests.values())


def with_one_to_come(problem: Problem) -> tuple[Problem, str, float | None]:
    """All but the last request in their routes; and what the last one costs at best, by brute force."""
    *earlier, last = problem.open_requests
    done = solve(replace(problem, open_requests=tuple(earlier)), Budget(), SEED)
    vehicles = tuple(
        replace(vehicle, calls=route.calls)
        for vehicle, route in zip(problem.vehicles, done.routes, strict=True)
    )
    loaded = replace(problem, vehicles=vehicles, open_requests=(last,))
    best = min(
        (
            cost - before
            for vehicle in vehicles
            if (before := cost_of(loaded, vehicle, vehicle.calls)) is not None
            for calls in every_insertion(vehicle.calls, problem.requests[last], problem.dwell_s)
            if (cost := cost_of(loaded, vehicle, calls)) is not None
        ),
        default=None,
    )
    return loaded, last, best


def require_sound(problem: Problem, solution: Solution) -> None:
    """Every rule looked at again, by other means than the schedule's own."""
    carried: list[str] = []
    for vehicle, route in zip(problem.vehicles, solution.routes, strict=True):
        clock_s, row, inside = vehicle.ready_s, vehicle.to_places_s, list(vehicle.aboard)
        left: dict[str, float] = {}
        for call, time in zip(route.calls, route.times, strict=True):
            assert abs(time.arrive_s - clock_s - row[call.place] * call.travel_time_factor) < 1e-6
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
            clock_s, row = time.leave_s, problem.times[call.place]
        assert not inside
    before = {name for vehicle in problem.vehicles for call in vehicle.calls for name in call.board}
    assert sorted([*carried, *solution.refused]) == sorted({*problem.open_requests, *before})


@BOUNDED
@given(problems(vehicles=2, wanted=6), st.integers(0, 3))
def test_every_request_is_carried_within_all_rules_or_refused(problem: Problem, slices: int) -> None:
    require_sound(problem, solve(problem, Budget(slices), SEED))


@BOUNDED
@given(problems(vehicles=2, wanted=6), st.integers(1, 3))
def test_improvement_never_costs_more_and_never_leaves_more_people(problem: Problem, slices: int) -> None:
    """Of several that ask at once others may be taken, never fewer."""
    plain = solve(problem, Budget(), SEED)
    better = solve(problem, Budget(slices), SEED)
    left = [sum(problem.requests[name].party for name in found.refused) for found in (better, plain)]
    assert left[0] <= left[1]
    if better.refused.keys() == plain.refused.keys():
        assert better.cost <= plain.cost + 1e-6
    assert better.slices <= slices


@BOUNDED
@given(problems(vehicles=2, wanted=5))
def test_the_same_problem_budget_and_seed_give_the_same_answer(problem: Problem) -> None:
    first, second = (solve(problem, Budget(2), 7) for _ in range(2))
    assert first == second


@BOUNDED
@given(problems(vehicles=1, wanted=4))
def test_what_is_promised_stays_in_its_windows_when_others_come_in(problem: Problem) -> None:
    first, *others = problem.open_requests
    alone = solve(replace(problem, open_requests=(first,)), Budget(), SEED)
    vehicles = (replace(problem.vehicles[0], calls=alone.routes[0].calls),)
    if first in alone.refused:
        return
    together = solve(replace(problem, vehicles=vehicles, open_requests=tuple(others)), Budget(2), 2)
    assert any(first in call.board for route in together.routes for call in route.calls)
    require_sound(problem, replace(together, refused=together.refused))


LINE = 100.0 * np.abs(np.arange(6)[:, None] - np.arange(6)[None, :])


def line(*places: int) -> VehicleState:
    """A vehicle at place 0 of a straight road with a place every 100 s."""
    calls = tuple(Call(place, fixed=True, dwell_s=10.0) for place in places)
    return VehicleState("v", LINE[0], 0.0, 6, 0, calls=calls)


def test_a_departure_keeps_its_order_and_its_times() -> None:
    chain = Chain(
        "trip",
        tuple(
            Call(p, dwell_s=10.0, leave_from_s=t, arrive_by_s=t + 50.0, fixed=True)
            for p, t in ((1, 300.0), (3, 700.0))
        ),
    )
    problem = Problem((line(2),), {}, LINE, open_chains=(chain,))
    route = solve(problem, Budget(), SEED).routes[0]
    assert [call.place for call in route.calls] in ([2, 1, 3], [1, 2, 3], [1, 3, 2])
    timed = {call.place: time for call, time in zip(route.calls, route.times, strict=True)}
    assert timed[1].leave_s >= 300.0
    assert timed[1].arrive_s <= 350.0
    assert timed[3].leave_s >= 700.0


def test_a_departure_that_nobody_can_make_in_time_is_refused() -> None:
    chain = Chain("trip", (Call(5, dwell_s=10.0, leave_from_s=100.0, arrive_by_s=150.0, fixed=True),))
    problem = Problem((line(),), {}, LINE, open_chains=(chain,))
    assert solve(problem, Budget(), SEED).refused == {"trip": "departure"}


def test_a_call_under_way_is_never_preceded_nor_joined() -> None:
    vehicle = replace(line(1, 4), locked=1)
    request = Request("r", 1, 3, 1, 0, 0.0, 9000.0, 9000.0)
    problem = Problem((vehicle,), {"r": request}, LINE, ("r",), dwell_s=10.0)
    calls = solve(problem, Budget(), SEED).routes[0].calls
    assert calls[0] == vehicle.calls[0]


def test_taking_a_request_out_drops_its_calls_but_no_fixed_ones() -> None:
    requests = {
        "a": Request("a", 1, 2, 1, 0, 0.0, 9e3, 9e3),
        "b": Request("b", 2, 3, 1, 0, 0.0, 9e3, 9e3),
    }
    calls = (Call(1, ("a",)), Call(2, ("b",), ("a",)), Call(3, (), ("b",), fixed=True, call_id="x"))
    schedule = Schedule(Problem((replace(line(), calls=calls),), requests, LINE))
    schedule.remove("b")
    assert schedule.routes()[0].calls == (
        Call(1, ("a",)),
        Call(2, (), ("a",)),
        Call(3, fixed=True, call_id="x"),
    )


def test_a_vehicle_that_accepts_nothing_gets_nothing() -> None:
    request = Request("r", 1, 3, 1, 0, 0.0, 9000.0, 9000.0)
    problem = Problem((replace(line(), accepts=False),), {"r": request}, LINE, ("r",), dwell_s=10.0)
    assert solve(problem, Budget(), SEED).refused == {"r": "no_vehicle_free"}
