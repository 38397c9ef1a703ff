from dataclasses import replace

import pytest

from server.dispatch.problem import Problem, Request
from server.dispatch.solve import Budget, solve
from tests.server.dispatch.schedule.test_schedule import TIMES, a_request, a_vehicle


@pytest.mark.parametrize(
    ("wish", "rule"),
    [
        (a_request(party=5), "seats"),
        (a_request(wheelchairs=2), "wheelchair"),
        (a_request(pickup_to_s=60.0), "pickup_window"),
        (a_request(arrive_by_s=200.0), "arrival"),
        (a_request(ride_s_max=100.0), "ride_time"),
    ],
)
def test_a_refusal_names_the_rule_that_binds(wish: Request, rule: str) -> None:
    problem = Problem((a_vehicle(),), {"a": wish}, TIMES, ("a",), dwell_s=10.0)
    assert solve(problem, Budget(), 0).refused == {"a": rule}


def test_a_fleet_at_work_is_asked_after_what_it_has_promised() -> None:
    first, second = a_request("a", 5, 7, pickup_to_s=520.0), a_request("b", 1, 0, pickup_to_s=90.0)
    problem = Problem((a_vehicle(),), {"a": first, "b": second}, TIMES, ("a", "b"), dwell_s=10.0)
    assert solve(problem, Budget(), 0).refused == {"b": "pickup_window"}


def test_without_vehicles_nobody_is_free() -> None:
    problem = Problem((replace(a_vehicle(), accepts=False),), {"a": a_request()}, TIMES, ("a",))
    assert solve(problem, Budget(), 0).refused == {"a": "no_vehicle_free"}
