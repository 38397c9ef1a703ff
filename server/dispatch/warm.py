"""Compiles the dispatcher's kernels into numba's cache, so that no booking meets the compiler."""

from dataclasses import replace

import numpy as np

from contract.geometry import arc_lengths, pose_at, project, wrap_angle
from server.dispatch.answer import PromiseRules, answer_all
from server.dispatch.decide import earliest_quotes
from server.dispatch.engine.warm import warm_search
from server.dispatch.problem import Call, Chain, Problem, Request, VehicleState, Walk
from server.dispatch.schedule.schedule import Schedule
from server.dispatch.solve import Budget, solve


def warm_kernels() -> None:
    warm_search()
    warm_bookings()
    warm_geometry()


def warm_geometry() -> None:
    """What asks for a place on the road: loaded later, a kernel needs a file that may not open then."""
    line = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    along = arc_lengths(line)
    pose_at(line, along, 0.5)
    project(line, along, 0.5, 0.1, 0, 3)
    wrap_angle(0.1)


def warm_bookings() -> None:
    """Solve a small problem with a departure, a late ride, a new one and one that has to be refused."""
    line = 100.0 * np.abs(np.arange(4.0)[:, None] - np.arange(4.0)[None, :])
    late = Request("late", 1, 2, 1, 0, 0.0, 10.0, 20.0, 50.0)
    new = Request("new", 2, 3, 1, 0, 0.0, 1e4, 2e4)
    far = Request("far", 3, 0, 1, 0, 0.0, 1.0, 2e4)
    departure = Chain("trip", (Call(1, (), (), 10.0, 900.0, 1200.0, True), Call(3, (), (), 10.0, fixed=True)))
    vehicle = VehicleState("v", line[0], 0.0, 4, 1, calls=(Call(1, ("late",)), Call(2, (), ("late",))))
    requests = {request.request_id: request for request in (late, new, far)}
    problem = Problem((vehicle,), requests, line, ("new", "far"), (departure,), 10.0)
    solve(problem, Budget(1, 10), 1)
    # A booking taken, which a second shuttle could have had, and one refused, with what is offered instead.
    other = VehicleState("w", line[3], 0.0, 4, 1)
    schedule = Schedule(replace(problem, vehicles=(vehicle, other), open_chains=()))
    for request in (new, far):
        schedule.add(request)
    near = tuple((Walk((place + 1) % 4, 60.0),) for place in range(4))
    answer_all(schedule, ["new", "far"], PromiseRules(later_s_max=3600.0, walks=near))
    # What an alternative would be quoted, which the two above do not come to.
    asked = Request("asked", 2, 3, 1, 0, 0.0, 1e4, 2e4)
    earliest_quotes(schedule, asked, ((2, 3, 0.0, 1e4, 2e4),))
