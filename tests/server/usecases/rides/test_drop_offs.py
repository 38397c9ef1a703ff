"""Where a party is let out: places a minute apart on one line, and a shuttle at the first of them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from server.dispatch.problem import Call, Problem, Request, VehicleRoute, VehicleState
from server.usecases.rides.drop_offs import (
    cheapest_with_drop_off,
    exits,
    first_index,
    without_drop_off,
)

PLACES, DWELL_S = 9, 10.0
TIMES = 60.0 * np.abs(np.arange(PLACES)[:, None] - np.arange(PLACES)[None, :])
LATEST_S = 3600.0


def shuttle(*calls: Call, aboard: tuple[str, ...] = (), locked: int = 0) -> VehicleState:
    return VehicleState("shuttle-1", TIMES[0], 0.0, 6, 1, aboard, calls, locked)


def party(name: str, pickup: int, dropoff: int, arrive_by_s: float = LATEST_S) -> Request:
    return Request(name, pickup, dropoff, 1, 0, 0.0, LATEST_S, arrive_by_s)


def board(place: int, *names: str) -> Call:
    return Call(place, names, (), DWELL_S)


def let_out(place: int, *names: str) -> Call:
    return Call(place, (), names, DWELL_S)


def cheapest(
    vehicle: VehicleState, ann_to: int, *others: Request, dwell_s: float = DWELL_S
) -> VehicleRoute | None:
    """Ann, who goes from 0 to 8, wants to get off at another place."""
    requests = {request.request_id: request for request in (party("ann", 0, 8), *others)}
    problem = Problem((vehicle,), requests, TIMES, dwell_s=DWELL_S)
    wanted = replace(requests["ann"], dropoff=ann_to, arrive_by_s=math.inf)
    out = Call(ann_to, (), ("ann",), dwell_s)
    return cheapest_with_drop_off(problem, vehicle, wanted, out)


def stops(route: VehicleRoute | None) -> list[tuple[int, tuple[str, ...], tuple[str, ...]]]:
    assert route is not None
    return [(call.place, call.board, call.alight) for call in route.calls]


@pytest.mark.parametrize(
    ("last", "locked", "kept"),
    [
        (let_out(8, "ann"), 0, 1),
        (let_out(8, "ann", "bob"), 0, 2),
        (Call(8, ("eve",), ("ann",)), 0, 2),
        (replace(let_out(8, "ann"), fixed=True), 0, 2),
        (let_out(8, "ann"), 1, 1),
        (let_out(8, "ann"), 2, 2),
    ],
)
def test_a_call_stays_without_the_party_only_if_something_else_needs_it(
    last: Call, locked: int, kept: int
) -> None:
    vehicle = shuttle(board(1, "bob"), last, aboard=("ann",), locked=locked)
    left = without_drop_off(vehicle, "ann")
    assert len(left) == kept
    assert all("ann" not in call.alight for call in left)
    assert left[0] == vehicle.calls[0]


def test_a_party_gets_off_after_it_was_fetched_and_after_the_calls_that_stay() -> None:
    calls = (board(1, "bob"), board(2, "ann"), let_out(3, "bob"))
    vehicle = shuttle(*calls)
    assert first_index(vehicle, calls, "ann") == 2
    assert first_index(vehicle, calls, "bob") == 1
    assert first_index(vehicle, calls, "dee") == 0
    assert first_index(replace(vehicle, locked=3), calls, "ann") == 3
    assert first_index(replace(vehicle, locked=1), calls, "ann") == 2


def test_who_wants_to_get_off_may_at_the_six_nearest_stops_and_at_all_planned_ones() -> None:
    vehicle = shuttle(let_out(4, "bob"), let_out(8, "ann"), aboard=("ann", "bob"))
    found = exits(TIMES, vehicle, "ann")
    assert found == [*((place, 0) for place in range(6)), (4, 0)]


def test_who_waits_or_stands_at_a_stop_may_get_off_at_another_one_only() -> None:
    vehicle = shuttle(board(2, "ann"), let_out(8, "ann"), let_out(7, "bob"), aboard=("bob",), locked=1)
    found = exits(TIMES, vehicle, "ann")
    assert found == [(1, 1), (3, 1), (0, 1), (4, 1), (5, 1), (6, 1), (7, 1)]


def test_nobody_is_let_out_where_no_road_leads() -> None:
    ways = np.where(np.arange(PLACES) < 3, TIMES[0], np.inf)
    vehicle = replace(shuttle(let_out(2, "ann"), aboard=("ann",)), to_places_s=ways)
    assert exits(TIMES, vehicle, "ann") == [(0, 0), (1, 0), (2, 0)]


def test_a_new_stop_is_made_where_it_costs_least() -> None:
    vehicle = shuttle(let_out(2, "bob"), let_out(6, "cid"), let_out(8, "ann"), aboard=("ann", "bob", "cid"))
    route = cheapest(vehicle, 4, party("bob", 0, 2), party("cid", 0, 6))
    assert stops(route) == [(2, (), ("bob",)), (4, (), ("ann",)), (6, (), ("cid",))]


def test_a_stop_that_is_made_anyway_serves_both() -> None:
    vehicle = shuttle(
        let_out(2, "bob"), let_out(6, "cid"), let_out(7, "dee"), aboard=("ann", "bob", "cid", "dee")
    )
    others = party("bob", 0, 2), party("cid", 0, 6), party("dee", 0, 7)
    route = cheapest(vehicle, 6, *others)
    assert stops(route) == [(2, (), ("bob",)), (6, (), ("cid", "ann")), (7, (), ("dee",))]


def test_a_break_between_shifts_is_no_stop_to_get_off() -> None:
    off = Call(4, (), (), 600.0, leave_from_s=900.0, fixed=True, call_id="off-duty-0", off_duty=True)
    route = cheapest(shuttle(off, aboard=("ann",)), 4)
    assert route is not None
    assert [call.alight for call in route.calls] == [("ann",)]
    assert route.times[0].arrive_s == pytest.approx(240.0)


def test_a_stop_that_breaks_another_s_promise_is_not_made() -> None:
    vehicle = shuttle(let_out(6, "bob"), aboard=("ann", "bob"))
    in_time, too_late = (party("bob", 0, 6, arrive_by_s) for arrive_by_s in (371.0, 369.0))
    first = [(4, (), ("ann",)), (6, (), ("bob",))]
    assert stops(cheapest(vehicle, 4, in_time)) == first
    assert stops(cheapest(vehicle, 4, too_late)) == first[::-1]


@pytest.mark.parametrize(("dwell_s", "ann_first"), [(1.0, True), (1.5, False)])
def test_nobody_who_is_late_already_comes_more_than_a_second_later(dwell_s: float, ann_first: bool) -> None:
    vehicle = shuttle(let_out(6, "bob"), aboard=("ann", "bob"))
    route = cheapest(vehicle, 4, party("bob", 0, 6, arrive_by_s=300.0), dwell_s=dwell_s)
    order = [(4, (), ("ann",)), (6, (), ("bob",))]
    assert stops(route) == (order if ann_first else order[::-1])


def test_who_is_late_may_choose_to_come_later_still() -> None:
    """The rule is there for the others."""
    vehicle = shuttle(board(1, "ann"), let_out(2, "ann"))
    ann = replace(party("ann", 1, 2), pickup_to_s=30.0)
    assert stops(cheapest(vehicle, 8, ann)) == [(1, ("ann",), ()), (8, (), ("ann",))]


def test_without_a_way_that_keeps_all_promises_there_is_no_route() -> None:
    vehicle = shuttle(let_out(8, "bob"), aboard=("ann", "bob"))
    bob = party("bob", 0, 8, arrive_by_s=485.0)
    assert stops(cheapest(replace(vehicle, on_duty_to_s=740.0), 4, bob))[-1] == (4, (), ("ann",))
    assert cheapest(replace(vehicle, on_duty_to_s=730.0), 4, bob) is None


def test_a_shuttle_that_ends_its_shift_late_anyway_still_lets_its_riders_out() -> None:
    vehicle = replace(shuttle(let_out(6, "bob"), aboard=("ann", "bob")), on_duty_to_s=100.0)
    assert stops(cheapest(vehicle, 4, party("bob", 0, 6))) == [(4, (), ("ann",)), (6, (), ("bob",))]
