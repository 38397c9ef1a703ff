"""Exact times on a straight road with a place every 100 s."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from server.dispatch.problem import Call, CallTime, Problem, Request, VehicleState
from server.dispatch.schedule.schedule import Schedule
from server.dispatch.solve import Budget, solve
from tests.server.dispatch.reference import Broken, schedule

TIMES = 100.0 * np.abs(np.arange(8)[:, None] - np.arange(8)[None, :])


def a_vehicle(**more: object) -> VehicleState:
    return replace(VehicleState("v", TIMES[0], 0.0, 4, 1), **more)  # type: ignore[arg-type]


def a_request(name: str = "a", pickup: int = 1, dropoff: int = 3, **more: object) -> Request:
    request = Request(name, pickup, dropoff, 1, 0, 0.0, 1e6, 1e6)
    return replace(request, **more)  # type: ignore[arg-type]


def the_calls(request: Request, dwell_s: float = 10.0) -> tuple[Call, Call]:
    name = request.request_id
    return Call(request.pickup, (name,), (), dwell_s), Call(request.dropoff, (), (name,), dwell_s)


def planned(calls: tuple[Call, ...], *requests: Request) -> tuple[tuple[CallTime, ...], Schedule]:
    """The times of these calls as the present route of one vehicle."""
    names = {request.request_id: request for request in requests}
    schedule = Schedule(Problem((a_vehicle(calls=calls),), names, TIMES, dwell_s=10.0))
    return schedule.route(0).times, schedule


def test_times_add_up_driving_and_dwelling() -> None:
    request = a_request()
    times, _ = planned(the_calls(request), request)
    assert [(t.arrive_s, t.leave_s) for t in times] == [(100.0, 110.0), (310.0, 320.0)]


@pytest.mark.parametrize("request_", [a_request(pickup_to_s=99.0), a_request(arrive_by_s=309.0)])
def test_a_promise_that_the_route_breaks_is_known_to_be_overdue(request_: Request) -> None:
    _, schedule = planned(the_calls(request_), request_)
    assert schedule.overdue == {"a"}


def test_a_pickup_is_left_later_rather_than_riding_too_long_through_a_wait() -> None:
    """Boarding a at once would keep it 500 s in the shuttle that waits for b's window."""
    a = a_request("a", 1, 3, ride_s_max=250.0)
    b = a_request("b", 2, 4, pickup_from_s=600.0)
    calls = (
        Call(1, ("a",), (), 10.0),
        Call(2, ("b",), (), 10.0),
        Call(3, (), ("a",), 10.0),
        Call(4, (), ("b",), 10.0),
    )
    times, schedule = planned(calls, a, b)
    assert not schedule.overdue
    assert times[2].arrive_s - times[0].leave_s <= 250.0
    assert times[2].arrive_s == 710.0


def test_waiting_cannot_help_when_the_road_itself_is_too_long() -> None:
    a, b = a_request("a", 1, 3, ride_s_max=205.0), a_request("b", 2, 4)
    calls = (
        Call(1, ("a",), (), 10.0),
        Call(2, ("b",), (), 10.0),
        Call(3, (), ("a",), 10.0),
        Call(4, (), ("b",), 10.0),
    )
    problem = Problem((a_vehicle(),), {"a": a, "b": b}, TIMES, dwell_s=10.0)
    times = schedule(problem, a_vehicle(), calls)
    assert times == Broken("ride_time", "a")
    assert planned(calls, a, b)[0][2].arrive_s - planned(calls, a, b)[0][0].leave_s == 210.0


@example((0, 0, 1601), 301, 300)
@example((0, 0, 1600), 301, 300)
@given(
    st.tuples(st.integers(0, 2000), st.integers(0, 1500), st.integers(0, 2000)),
    st.integers(200, 800),
    st.integers(200, 800),
)
@settings(max_examples=80, deadline=None)
def test_a_schedule_exists_exactly_when_some_delay_of_the_pickups_works(
    opens: tuple[int, int, int], longest_a: int, longest_b: int
) -> None:
    """Against a search over all delays of the departures, in steps that contain the least solution."""
    a = a_request("a", 1, 4, pickup_from_s=float(opens[0]), ride_s_max=float(longest_a))
    b = a_request("b", 2, 5, pickup_from_s=float(opens[1]), ride_s_max=float(longest_b), pickup_to_s=1500.0)
    timed = Call(3, (), (), 0.0, leave_from_s=float(opens[2]), fixed=True)
    calls = (
        Call(1, ("a",), (), 0.0),
        Call(2, ("b",), (), 0.0),
        timed,
        Call(4, (), ("a",), 0.0),
        Call(5, (), ("b",), 0.0),
    )
    problem = Problem((a_vehicle(),), {"a": a, "b": b}, TIMES)
    found = schedule(problem, a_vehicle(), calls)
    times, _ = planned(calls, a, b)
    if not isinstance(found, Broken):
        assert [t.arrive_s for t in times] == pytest.approx([t.arrive_s for t in found])
    candidates = range(0, 2401)
    feasible = False
    for leave_a in candidates:
        if leave_a < max(100, opens[0]):
            continue
        arrive_b = leave_a + 100
        if arrive_b > 1500:
            break
        arrive_3 = max(arrive_b, opens[1]) + 100
        # b boards at 1500 at the latest, even if the shuttle stands there longer.
        latest_leave_b = max(min(max(arrive_3, opens[2]) - 100, 1500), arrive_b, opens[1])
        arrive_4 = max(arrive_3, opens[2]) + 100
        arrive_5 = arrive_4 + 100
        if arrive_4 - leave_a <= longest_a and arrive_5 - latest_leave_b <= longest_b:
            feasible = True
            break
    assert isinstance(found, Broken) != feasible


def test_a_late_route_is_loosened_just_as_far_as_it_is_late() -> None:
    late = a_request(pickup_to_s=50.0, arrive_by_s=200.0)
    times, schedule = planned(the_calls(late), late)
    assert [t.arrive_s for t in times] == [100.0, 310.0]
    row = 2 * schedule.rows["a"]
    assert list(schedule.task.late_s[row : row + 2]) == pytest.approx([100.0, 310.0], abs=0.01)


def test_nobody_is_inserted_before_a_ride_that_is_late_already() -> None:
    late, new = a_request("a", 3, 5, pickup_to_s=50.0), a_request("b", 1, 2)
    vehicle = a_vehicle(calls=the_calls(late))
    problem = Problem((vehicle,), {"a": late, "b": new}, TIMES, ("b",), dwell_s=10.0)
    calls = solve(problem, Budget(), 0).routes[0].calls
    assert calls[0].board == ("a",)


def test_a_vehicle_with_more_people_than_seats_is_left_out_of_decisions() -> None:
    many = a_request(party=9)
    full = a_vehicle(calls=the_calls(many))
    problem = Problem((full, a_vehicle(vehicle_id="w")), {"a": many}, TIMES)
    solution = solve(problem, Budget(3), 0)
    assert solution.impossible == ("v",)
    assert [route.vehicle_id for route in solution.routes] == ["w"]


@pytest.mark.parametrize(("opens_s", "places"), [(300.0, [1, 3]), (900.0, [1, 1, 3])])
def test_riders_at_a_stop_do_not_wait_there_for_a_party_that_boards_much_later(
    opens_s: float, places: list[int]
) -> None:
    at_once, later = a_request("a", 1, 3), a_request("b", 1, 3, pickup_from_s=opens_s)
    together = (Call(1, ("a", "b"), (), 10.0), Call(3, (), ("a", "b"), 10.0))
    names = {"a": at_once, "b": later}
    problem = Problem((a_vehicle(calls=together),), names, TIMES, dwell_s=10.0, together=True)
    (route,) = solve(problem, Budget(), 0).routes
    assert [call.place for call in route.calls] == places


@pytest.mark.parametrize(("opens_s", "places"), [(200.0, [1, 3]), (300.0, [1, 1, 3])])
def test_calls_that_are_apart_stay_apart_a_while(opens_s: float, places: list[int]) -> None:
    at_once, later = a_request("a", 1, 3), a_request("b", 1, 3, pickup_from_s=opens_s)
    calls = (
        Call(1, ("a",), (), 10.0, call_id="first"),
        Call(1, ("b",), (), 10.0, call_id="second"),
        Call(3, (), ("a", "b"), 10.0, call_id="last"),
    )
    problem = Problem(
        (a_vehicle(calls=calls),), {"a": at_once, "b": later}, TIMES, dwell_s=10.0, together=True
    )
    (route,) = solve(problem, Budget(), 0).routes
    assert [call.place for call in route.calls] == places
