"""The routes of the fleet as the engine computes on them: a problem as rows of arrays, and routes as calls.

A schedule is filled once from a problem and then kept. Requests are added and removed, vehicles move on, and
a decision touches only the rows that it changes. A promise that cannot be kept is extended to what the
present route still reaches. So every route of the schedule is feasible, and no late ride is made later.
"""

from collections.abc import Container, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from server.dispatch.engine.plan import ABSENT, Plan, Scratch, empty_plan, refresh, scratch_for
from server.dispatch.engine.task import Task
from server.dispatch.problem import Call, Problem, Request, VehicleRoute, VehicleState
from server.dispatch.schedule.advance import advance, made_log
from server.dispatch.schedule.layout import calls_and_times
from server.dispatch.schedule.rows import TaskRows, fixed_calls
from server.dispatch.schedule.settle import settle

# Room for new requests and visits, beside those of the problem.
_SPARE_ROWS = 8
_SPARE_VISITS = 40


@dataclass(frozen=True, slots=True)
class PlannedCall:
    """The row of the vehicle, and when boarding begins and the ride ends."""

    vehicle: int
    pickup_s: float
    arrival_s: float


@dataclass(frozen=True, slots=True)
class CompletedCall:
    """A rider was picked up, or set down (alights), at this time."""

    vehicle_id: str
    request_id: str
    alights: bool
    at_s: float


class Schedule:
    """The fleet's routes over the rows of a problem (`TaskRows` says which row and node is what).

    rows, requests  the row of each request by its id, and the request of each row
    impossible  vehicles with more people than seats, because a report crossed a decision; they keep their
                riders and get no others
    overdue     requests, and names of fixed calls, that the present routes serve too late
    """

    def __init__(
        self,
        problem: Problem,
        spare: int = _SPARE_ROWS,
        departure_slack: float = 0.0,
        visits: int = _SPARE_VISITS,
    ) -> None:
        """spare, visits  room for so many more requests, and for so many more visits of one vehicle
        departure_slack  when vehicles set out in `advance`: 0 as early as possible, 1 as late as every
        promise allows"""
        self.problem = problem
        self._rows = TaskRows(problem, spare)
        self.origin_s = self._rows.origin_s
        self.rows, self.requests = self._rows.numbers, self._rows.requests
        self.vehicle_ids = [vehicle.vehicle_id for vehicle in problem.vehicles]
        self.impossible: set[int] = set()
        self.overdue: set[str] = set()
        room = max((_visits(vehicle) for vehicle in problem.vehicles), default=0) + visits
        room += 2 * fixed_calls(problem)
        self.plan: Plan = empty_plan(self.task, room)
        self.scratch: Scratch = scratch_for(self.task, room)
        self.accepts = np.zeros(len(problem.vehicles), np.bool_)
        self._made = made_log(len(problem.vehicles) * self.plan.route.shape[1])
        self._driven_s = 0.0
        self._departure_slack = departure_slack
        for v, vehicle in enumerate(problem.vehicles):
            self._place(v, vehicle)

    def _place(self, v: int, vehicle: VehicleState) -> None:
        """Fill the route of a vehicle with its riders aboard and its calls."""
        plan, requests = self.plan, self.task.requests
        self._rows.place_vehicle(v, vehicle)
        self.accepts[v] = vehicle.accepts
        for request_id in vehicle.aboard:
            r = self.rows[request_id]
            plan.movable[r] = False
            plan.vehicle_of[r] = v
        nodes, locked = self._rows.enter_calls(vehicle)
        riders = (node >> 1 for node in nodes if node < 2 * requests)
        plan.vehicle_of[np.fromiter(riders, np.int64)] = v
        for number, node in enumerate(nodes):
            if node < 2 * requests and (number < locked - 1 or self.requests[node >> 1].pinned):
                plan.movable[node >> 1] = False
        self._write_route(v, nodes, locked)
        if not vehicle.accepts:
            self._freeze(v)

    @property
    def task(self) -> Task:
        """The engine's arrays that the routes are computed on."""
        return self._rows.task

    # ------------------------------------------------------------ requests and fixed calls

    def add(self, request: Request) -> int:
        """The row of a request; a new one is in no route yet."""
        if request.request_id in self.rows:
            return self.rows[request.request_id]
        r = self._rows.add(request)
        self.plan.vehicle_of[r] = ABSENT
        self.plan.movable[r] = True
        return r

    def write(self, r: int, request: Request) -> None:
        """Make row r this request; its service times stay."""
        self._rows.write(r, request)

    def add_fixed(self, call: Call) -> int:
        """The node of a call that is made even if no rider boards or alights."""
        return self._rows.add_fixed(call)

    def keep(self, request_id: str) -> None:
        """Accept the request: no improvement may leave it out."""
        self._rows.keep(self.rows[request_id])

    def narrow(self, request: Request) -> None:
        """Accept a request that is in a route, with other windows, which the route keeps."""
        r = self.rows[request.request_id]
        self.write(r, request)
        self._rows.keep(r)
        refresh(self.task, self.plan, self.scratch, int(self.plan.vehicle_of[r]))

    def take_out(self, request_id: str) -> None:
        """Take the request out of its route; it stays in the schedule."""
        r = self.rows[request_id]
        v = int(self.plan.vehicle_of[r])
        self.plan.vehicle_of[r] = ABSENT
        for node in (2 * r, 2 * r + 1):
            self._rows.stays.pop(node, None)
        if v != ABSENT:
            nodes = [node for node in self.nodes(v) if node >> 1 != r]
            self._write_route(v, nodes, int(self.plan.locked[v]))

    def remove(self, request_id: str) -> None:
        """Forget a request, and take it out of its route."""
        self.take_out(request_id)
        self._release(self.rows[request_id])

    def withdraw(self, request_id: str) -> bool:
        """Cancel a request before its pickup. Returns whether a vehicle has already set out for it.

        Such a vehicle drives on to the stop and is free there, without opening its doors.
        """
        r = self.rows[request_id]
        v = int(self.plan.vehicle_of[r])
        in_vain = v != ABSENT and self.plan.locked[v] > 1 and self.plan.route[v, 1] == 2 * r
        if in_vain:
            self._rows.start_at(v, 2 * r)
            self.plan.locked[v] = 1
        self.remove(request_id)
        return bool(in_vain)

    def _release(self, r: int) -> None:
        self._rows.release(r)
        self.plan.vehicle_of[r] = ABSENT

    # ------------------------------------------------------------ time goes on

    def advance(self, now_s: float) -> list[CompletedCall]:
        """Let every vehicle drive as planned until now. Returns the visits made, each vehicle's in order.

        A vehicle sets out for its next visit as late as its departure slack says. From then on the visit is
        fixed.
        A request that has been set down leaves the schedule.
        """
        self._driven_s += advance(
            self.task, self.plan, self.scratch, now_s - self.origin_s, self._departure_slack, self._made
        )
        if self._made.used[1]:
            raise RuntimeError("a feasible route broke a rule although it was driven as planned")
        made: list[CompletedCall] = []
        for k in range(int(self._made.used[0])):
            node, v = int(self._made.node[k]), int(self._made.vehicle[k])
            at_s = float(self._made.at_s[k]) + self.origin_s
            self._rows.stays.pop(node, None)
            if node >= 2 * self.task.requests:
                continue
            r, alights = node >> 1, bool(node & 1)
            made.append(CompletedCall(self.vehicle_ids[v], self.requests[r].request_id, alights, at_s))
            if alights:
                self._release(r)
        return made

    @property
    def driven_s(self) -> float:
        """Driving begun so far by all vehicles."""
        return float(self._driven_s)

    # ------------------------------------------------------------ routes

    def nodes(self, v: int) -> list[int]:
        """Visits of a vehicle's route, without its start and end."""
        return [int(node) for node in self.plan.route[v, 1 : self.plan.length[v] - 1]]

    def _write_route(self, v: int, nodes: Sequence[int], locked: int) -> None:
        route, start = self.plan.route[v], 2 * (self.task.requests + v)
        route[0], route[1 : len(nodes) + 1], route[len(nodes) + 1] = start, nodes, start + 1
        self.plan.length[v] = len(nodes) + 2
        self.plan.locked[v] = locked
        if refresh(self.task, self.plan, self.scratch, v):
            return
        late = settle(self.task, self.plan, self.scratch, v)
        self.overdue.update(self._rows.name_of(node) for node in late)
        if not refresh(self.task, self.plan, self.scratch, v):
            self.impossible.add(v)
            self._freeze(v)

    def _freeze(self, v: int) -> None:
        """No decision changes this route any more."""
        self.accepts[v] = False
        self.plan.locked[v] = self.plan.length[v]
        for node in self.nodes(v):
            if node < 2 * self.task.requests:
                self.plan.movable[node >> 1] = False

    def arrival_s(self, request_id: str) -> float:
        """The planned arrival of a request in a route, or of a rider aboard."""
        r = self.rows[request_id]
        v = int(self.plan.vehicle_of[r])
        return float(self.plan.least_s[v, self.plan.slot[2 * r + 1]]) + self.origin_s

    def planned(self, request_id: str) -> PlannedCall:
        """The planned pickup and arrival of a request in a route."""
        r = self.rows[request_id]
        v = int(self.plan.vehicle_of[r])
        pickup_s, arrival_s = (self.plan.least_s[v, self.plan.slot[node]] for node in (2 * r, 2 * r + 1))
        return PlannedCall(v, float(pickup_s) + self.origin_s, float(arrival_s) + self.origin_s)

    def retime(self) -> None:
        """Compute times and cost of every route again, after the task has changed."""
        for v in range(len(self.vehicle_ids)):
            if v not in self.impossible:
                refresh(self.task, self.plan, self.scratch, v)

    def route(self, v: int) -> VehicleRoute:
        """A vehicle's calls with their times."""
        calls, times = calls_and_times(
            self.task, self.plan, v, self._rows.stays, self.requests, self.origin_s
        )
        made = [pair for pair in zip(calls, times, strict=True) if not pair[0].off_duty]
        return VehicleRoute(
            self.vehicle_ids[v], tuple(call for call, _ in made), tuple(time for _, time in made)
        )

    def off_duty_nodes(self) -> list[int]:
        """The calls that stand for time off between two shifts."""
        return [node for node, stay in self._rows.stays.items() if stay.call.off_duty]

    def routes(self, vehicle_ids: Container[str] | None = None) -> tuple[VehicleRoute, ...]:
        """Every vehicle's route, or those of the named ones; impossible ones are left out."""
        return tuple(
            self.route(v)
            for v, vehicle_id in enumerate(self.vehicle_ids)
            if v not in self.impossible and (vehicle_ids is None or vehicle_id in vehicle_ids)
        )

    @property
    def cost(self) -> float:
        """Weighted seconds of all routes, up to a constant of the problem."""
        return float(sum(self.plan.cost[v] for v in range(len(self.vehicle_ids)) if v not in self.impossible))

    def carried(self, request_ids: Iterable[str]) -> list[str]:
        """Those of the requests that are in some route."""
        return [name for name in request_ids if self.plan.vehicle_of[self.rows[name]] != ABSENT]


def _visits(vehicle: VehicleState) -> int:
    riders = sum(len(call.board) + len(call.alight) for call in vehicle.calls)
    return riders + len(vehicle.calls) + 2
