"""Requests entered together are the same rows as requests added one by one."""

from dataclasses import replace

from hypothesis import given, settings

from server.dispatch.problem import Problem
from server.dispatch.schedule.blank_task import blank_task, fill_rows
from server.dispatch.schedule.schedule import Schedule
from tests.server.dispatch.problems import problems

FIELDS = ("place", "early_s", "late_s", "service_s", "ride_s_max", "delay_cost", "travel_time_factor")


@given(problems())
@settings(max_examples=60, deadline=None)
def test_rows_are_the_same_however_they_were_filled(problem: Problem) -> None:
    vehicles = tuple(replace(vehicle, calls=(), aboard=()) for vehicle in problem.vehicles)
    empty = replace(problem, vehicles=vehicles)
    requests = list(problem.requests.values())
    schedule = Schedule(empty)
    task = blank_task(empty, len(requests), 2 * len(requests))
    fill_rows(task, requests, empty, schedule.origin_s)
    for number, request in enumerate(requests):
        r = schedule.add(request)
        assert task.absent_cost[number] == request.party
        for node, other in ((2 * number, 2 * r), (2 * number + 1, 2 * r + 1)):
            for field in FIELDS:
                assert getattr(task, field)[node] == getattr(schedule.task, field)[other], field
            assert (task.load[node] == schedule.task.load[other]).all()
