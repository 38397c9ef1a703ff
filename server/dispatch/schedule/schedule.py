"""The routes of the fleet as the engine computes on them: a problem as rows of arrays, and routes as calls.

A schedule is filled once from a problem and then kept. Requests are added and removed, vehicles move on, and
a decision touches only the rows that it changes. A promise that cannot be kept is extended to what the
present route still reaches. So every route of the schedule is feasible, and no late ride is made later.
"""

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from server.dispatch.engine.plan import ABSENT, Plan, Scratch, empty_plan, refresh, scratch_for
from server.dispatch.engine.task import SEATS, WHEELCHAIRS
from server.dispatch.problem import CUT_OFF_S, Call, Problem, Request, VehicleRoute, VehicleState
from server.dispatch.schedule.advance import advance, made_log
from server.dispatch.schedule.blank_task import blank_task, fill_rows, finite
from server.dispatch.schedule.layout import Stay, calls_and_times
from server.dispatch.schedule.settle import settle

# Room for new requests and visits, beside those of the problem.
_SPARE_ROWS = 8
_SPARE_VISITS = 40
# The cost of leaving one person out. An accepted request never makes way for new ones.
_ASKING, _PROMISED = 1e7, 1e11


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
    """Rows: request r has nodes 2r and 2r + 1, vehicle v starts at 2(R + v) and ends at 2(R + v) + 1.

    impossible  vehicles with more people than seats, because a report crossed a decision; they keep their
                riders and get no others
    overdue     requests, and names of fixed calls, that the present routes serve too late
    """

    def __init__(
        self,
        problem: Problem,
        spare: int = _SPARE_ROWS,
        patience: float = 0.0,
        visits: int = _SPARE_VISITS,
    ) -> None:
        """spare, visits  room for so many more requests, and for so many more visits of one vehicle
        patience  when vehicles set out in `advance`: 0 as early as possible, 1 as late as every promise
        allows"""
        self.problem = problem
        self.origin_s = min((vehicle.ready_s for vehicle in problem.vehicles), default=0.0)
        self.vehicle_ids = [vehicle.vehicle_id for vehicle in problem.vehicles]
        self.rows: dict[str, int] = {}
        self.requests: dict[int, Request] = {}
        self._places = len(problem.times) if problem.plane is None else len(problem.plane.xy)
        self.impossible: set[int] = set()
        self.overdue: set[str] = set()
        self._stays: dict[int, Stay] = {}
        capacity = len(problem.requests) + spare
        self._free = list(range(capacity - 1, -1, -1))
        fixed = sum(_stands(call) for vehicle in problem.vehicles for call in vehicle.calls)
        fixed += sum(len(chain.calls) for chain in problem.open_chains)
        self._next_fixed = 2 * (capacity + len(problem.vehicles))
        self.task = blank_task(problem, capacity, self._next_fixed + 2 * fixed)
        room = max((_visits(vehicle) for vehicle in problem.vehicles), default=0) + visits
        self.plan: Plan = empty_plan(self.task, room + 2 * fixed)
        self.scratch: Scratch = scratch_for(self.task, room + 2 * fixed)
        self.accepts = np.zeros(len(problem.vehicles), np.bool_)
        self._made = made_log(len(problem.vehicles) * self.plan.route.shape[1])
        self._driven_s = 0.0
        self._patience = patience
        self._enter(list(_named(problem)))
        for v, vehicle in enumerate(problem.vehicles):
            self._place(v, vehicle)

    # ------------------------------------------------------------ filling

    def _enter(self, names: list[str]) -> None:
        """Make these requests the first rows of an empty schedule: promised, and in no route yet.

        The same as `add` and `keep` for each one, several times as fast.
        """
        requests = [self.problem.requests[name] for name in names]
        if not requests:
            return
        count = len(requests)
        self.rows = {name: r for r, name in enumerate(names)}
        self.requests = dict(enumerate(requests))
        del self._free[-count:]
        fill_rows(self.task, requests, self.problem, self.origin_s)
        self.task.absent_cost[:count] *= _PROMISED
        if any(request.pace != 1.0 for request in requests):
            self.task = self.task._replace(paced=True)

    def add(self, request: Request) -> int:
        """The row of a request, which is in no route yet."""
        if request.request_id in self.rows:
            return self.rows[request.request_id]
        if not self._free:
            raise ValueError("the schedule has no free row; make one with more spare rows")
        r = self._free.pop()
        self.rows[request.request_id] = r
        self.write(r, request, self.problem.dwell_s if request.dwell_s is None else request.dwell_s)
        self._set_pace(2 * r, request.pace)
        self._set_pace(2 * r + 1, request.pace)
        self.plan.vehicle_of[r] = ABSENT
        self.plan.movable[r] = True
        return r

    def _set_pace(self, node: int, pace: float) -> None:
        """A request keeps its first travel time factor, so that narrower windows never change its times."""
        self.task.pace[node] = pace
        if pace != 1.0 and not self.task.paced:
            self.task = self.task._replace(paced=True)

    def write(self, r: int, request: Request, dwell_s: float | None = None) -> None:
        """Make row r this request; its service times stay where dwell_s is None."""
        self.requests[r] = request
        task, weights, p, d = self.task, self.problem.weights, 2 * r, 2 * r + 1
        from_s = request.pickup_from_s - self.origin_s
        task.place[p], task.place[d] = request.pickup, request.dropoff
        task.early_s[p] = from_s
        task.early_s[d] = max(from_s, request.arrive_from_s - self.origin_s)
        task.late_s[p] = request.pickup_to_s - self.origin_s
        task.late_s[d] = min(request.arrive_by_s - self.origin_s, 0.5 * CUT_OFF_S)
        task.ride_s_max[p] = request.ride_s_max
        task.load[p, SEATS], task.load[p, WHEELCHAIRS] = request.party, request.wheelchairs
        task.load[d] = -task.load[p]
        # Waiting to be picked up, then riding: with the end fixed, a later pickup makes the ride shorter.
        task.delay_cost[p] = (weights.wait - weights.ride) * request.party
        task.delay_cost[d] = weights.ride * request.party
        task.absent_cost[r] = _ASKING * request.party
        if dwell_s is not None:
            task.service_s[p] = task.service_s[d] = dwell_s

    def take_out(self, request_id: str) -> None:
        """Take the request out of its route; it stays in the schedule."""
        r = self.rows[request_id]
        v = int(self.plan.vehicle_of[r])
        self.plan.vehicle_of[r] = ABSENT
        for node in (2 * r, 2 * r + 1):
            self._stays.pop(node, None)
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
            task, start = self.task, int(self.plan.route[v, 0])
            here, there = task.place[start], task.place[2 * r]
            if self.problem.plane is None:
                task.travel_s[here] = task.travel_s[there]
            else:
                task.xy[here] = task.xy[there]
            task.early_s[start] = task.early_s[2 * r]
            self.plan.locked[v] = 1
        self.remove(request_id)
        return bool(in_vain)

    def _release(self, r: int) -> None:
        del self.rows[self.requests.pop(r).request_id]
        self.plan.vehicle_of[r] = ABSENT
        self.task.absent_cost[r] = 0.0
        self._free.append(r)

    def keep(self, request_id: str) -> None:
        """Accept the request: no improvement may leave it out."""
        r = self.rows[request_id]
        self.task.absent_cost[r] = _PROMISED * self.requests[r].party

    def narrow(self, request: Request) -> None:
        """Accept a request that is in a route, with other windows, which the route keeps."""
        r = self.rows[request.request_id]
        self.write(r, request)
        self.keep(request.request_id)
        refresh(self.task, self.plan, self.scratch, int(self.plan.vehicle_of[r]))

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

    def add_fixed(self, call: Call) -> int:
        """The node of a call that is made even if no rider boards or alights."""
        node = self._next_fixed
        self._next_fixed += 2
        task = self.task
        early_s = call.leave_from_s - call.dwell_s - self.origin_s
        timed = np.isfinite(early_s)
        task.place[node] = call.place
        self._set_pace(node, call.pace)
        task.service_s[node] = call.dwell_s
        task.early_s[node] = early_s if timed else -CUT_OFF_S
        late_s = min(call.arrive_by_s - self.origin_s, 0.5 * CUT_OFF_S)
        task.late_s[node] = max(late_s, task.early_s[node])
        task.delay_cost[node] = self.problem.weights.late if timed else 0.0
        self._stays[node] = Stay(call, len(self._stays))
        return node

    def _place(self, v: int, vehicle: VehicleState) -> None:
        task, requests = self.task, self.task.requests
        start = 2 * (requests + v)
        task.place[start], task.place[start + 1] = self._places + v, vehicle.ends_at
        if self.problem.plane is None:
            task.travel_s[self._places + v] = finite(vehicle.to_places_s)
        else:
            task.xy[self._places + v] = vehicle.at_xy
        task.early_s[start], task.late_s[start] = vehicle.ready_s - self.origin_s, CUT_OFF_S
        task.ride_s_max[start] = vehicle.duty_s_max
        task.early_s[start + 1] = -CUT_OFF_S
        task.late_s[start + 1] = min(vehicle.on_duty_to_s - self.origin_s, CUT_OFF_S)
        task.capacity[v] = vehicle.seats, vehicle.wheelchair_places
        task.drive_s_max[v] = vehicle.drive_s_max
        task.load[start] = 0
        self.accepts[v] = vehicle.accepts
        for request_id in vehicle.aboard:
            self._board_now(v, start, request_id)
        nodes: list[int] = []
        locked = 1
        for number, call in enumerate(vehicle.calls):
            stay = Stay(call, len(self._stays))
            if call.fixed or (number < vehicle.locked and _stands(call)):
                nodes.append(self.add_fixed(call))
            for request_id in call.alight:
                nodes.append(self._known(request_id, call, stay) + 1)
            for request_id in call.board:
                nodes.append(self._known(request_id, call, stay))
            if number < vehicle.locked:
                locked = len(nodes) + 1
        riders = (node >> 1 for node in nodes if node < 2 * requests)
        self.plan.vehicle_of[np.fromiter(riders, np.int64)] = v
        for number, node in enumerate(nodes):
            if node < 2 * requests and (number < locked - 1 or self.requests[node >> 1].pinned):
                self.plan.movable[node >> 1] = False
        self._write_route(v, nodes, locked)
        if not vehicle.accepts:
            self._freeze(v)

    def _known(self, request_id: str, call: Call, stay: Stay) -> int:
        """The pickup node of a request that a call names; the visit there is that call."""
        r = self.rows[request_id]
        node = 2 * r + (request_id in call.alight)
        self.task.service_s[node] = call.dwell_s
        self._set_pace(node, call.pace)
        self._stays[node] = stay
        return 2 * r

    def _board_now(self, v: int, start: int, request_id: str) -> None:
        """A rider aboard has a drop-off only; where it began is behind the vehicle."""
        r = self.rows[request_id]
        self.task.load[start] += self.task.load[2 * r]
        self.task.ride_s_max[2 * r] = np.inf
        self.plan.movable[r] = False
        self.plan.vehicle_of[r] = v

    # ------------------------------------------------------------ time goes on

    def advance(self, now_s: float) -> list[CompletedCall]:
        """Let every vehicle drive as planned until now. Returns the visits made, each vehicle's in order.

        A vehicle sets out for its next visit as late as its patience says. From then on the visit is fixed.
        A request that has been set down leaves the schedule.
        """
        self._driven_s += advance(
            self.task, self.plan, self.scratch, now_s - self.origin_s, self._patience, self._made
        )
        if self._made.used[1]:
            raise RuntimeError("a feasible route broke a rule although it was driven as planned")
        made: list[CompletedCall] = []
        for k in range(int(self._made.used[0])):
            node, v = int(self._made.node[k]), int(self._made.vehicle[k])
            at_s = float(self._made.at_s[k]) + self.origin_s
            self._stays.pop(node, None)
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
        self.overdue.update(self._name(node) for node in late)
        if not refresh(self.task, self.plan, self.scratch, v):
            self.impossible.add(v)
            self._freeze(v)

    def _name(self, node: int) -> str:
        """The request or the call whose visit it is; "" for the end of a shift."""
        if node < 2 * self.task.requests:
            return self.requests[node >> 1].request_id
        return self._stays[node].call.call_id if node in self._stays else ""

    def _freeze(self, v: int) -> None:
        """No decision changes this route any more."""
        self.accepts[v] = False
        self.plan.locked[v] = self.plan.length[v]
        for node in self.nodes(v):
            if node < 2 * self.task.requests:
                self.plan.movable[node >> 1] = False

    def retime(self) -> None:
        """Compute times and cost of every route again, after the task has changed."""
        for v in range(len(self.vehicle_ids)):
            if v not in self.impossible:
                refresh(self.task, self.plan, self.scratch, v)

    def route(self, v: int) -> VehicleRoute:
        """A vehicle's calls with their times."""
        calls, times = calls_and_times(self.task, self.plan, v, self._stays, self.requests, self.origin_s)
        made = [pair for pair in zip(calls, times, strict=True) if not pair[0].off_duty]
        return VehicleRoute(
            self.vehicle_ids[v], tuple(call for call, _ in made), tuple(time for _, time in made)
        )

    def off_duty_nodes(self) -> list[int]:
        """The calls that stand for time off between two shifts."""
        return [node for node, stay in self._stays.items() if stay.call.off_duty]

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


def _stands(call: Call) -> bool:
    """The call has a node of its own: it is fixed, or has no riders."""
    return call.fixed or not (call.board or call.alight)


def _named(problem: Problem) -> Iterator[str]:
    """Every request that some vehicle carries or is to carry, once."""
    seen = dict.fromkeys(
        request_id
        for vehicle in problem.vehicles
        for riders in (vehicle.aboard, *(ids for call in vehicle.calls for ids in (call.alight, call.board)))
        for request_id in riders
    )
    return iter(seen)


def _visits(vehicle: VehicleState) -> int:
    riders = sum(len(call.board) + len(call.alight) for call in vehicle.calls)
    return riders + len(vehicle.calls) + 2
