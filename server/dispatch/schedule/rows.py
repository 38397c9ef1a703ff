"""A problem as rows of the engine's arrays: requests, fixed calls, and where vehicles start and end."""

from collections.abc import Iterator

import numpy as np

from server.dispatch.engine.task import SEATS, WHEELCHAIRS, Task
from server.dispatch.problem import CUT_OFF_S, Call, Problem, Request, VehicleState
from server.dispatch.schedule.blank_task import blank_task, fill_rows, finite
from server.dispatch.schedule.layout import Stay

# The cost of leaving one person out. An accepted request never makes way for new ones.
_ASKING, _PROMISED = 1e7, 1e11


class TaskRows:
    """Request r has nodes 2r and 2r + 1, vehicle v starts at 2(R + v) and ends at 2(R + v) + 1, and the fixed
    calls follow. It knows no routes.

    numbers   the row of each request by its id; requests: the request of each row
    stays     the call that a node belonged to when it was entered
    origin_s  times in the task count from here
    """

    def __init__(self, problem: Problem, spare: int) -> None:
        """spare  room for so many more requests than the problem names"""
        self.problem = problem
        self.origin_s = min((vehicle.ready_s for vehicle in problem.vehicles), default=0.0)
        self.numbers: dict[str, int] = {}
        self.requests: dict[int, Request] = {}
        self.stays: dict[int, Stay] = {}
        self._places = len(problem.times) if problem.plane is None else len(problem.plane.xy)
        capacity = len(problem.requests) + spare
        self._free = list(range(capacity - 1, -1, -1))
        self._next_fixed = 2 * (capacity + len(problem.vehicles))
        self.task: Task = blank_task(problem, capacity, self._next_fixed + 2 * fixed_calls(problem))
        self._enter(list(_named(problem)))

    # ------------------------------------------------------------ requests

    def _enter(self, names: list[str]) -> None:
        """Make these requests the first rows of an empty task, promised.

        The same as `add` and `keep` for each one, several times as fast.
        """
        requests = [self.problem.requests[name] for name in names]
        if not requests:
            return
        count = len(requests)
        self.numbers.update((name, r) for r, name in enumerate(names))
        self.requests.update(enumerate(requests))
        del self._free[-count:]
        fill_rows(self.task, requests, self.problem, self.origin_s)
        self.task.absent_cost[:count] *= _PROMISED
        if any(request.travel_time_factor != 1.0 for request in requests):
            self.task = self.task._replace(has_travel_time_factors=True)

    def add(self, request: Request) -> int:
        """The row of a request that has none yet."""
        if not self._free:
            raise ValueError("the schedule has no free row; make one with more spare rows")
        r = self._free.pop()
        self.numbers[request.request_id] = r
        self.write(r, request, self.problem.dwell_s if request.dwell_s is None else request.dwell_s)
        self._set_travel_time_factor(2 * r, request.travel_time_factor)
        self._set_travel_time_factor(2 * r + 1, request.travel_time_factor)
        return r

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

    def keep(self, r: int) -> None:
        """Accept the request of this row: no improvement may leave it out."""
        self.task.absent_cost[r] = _PROMISED * self.requests[r].party

    def release(self, r: int) -> None:
        """Forget the request of this row, which is free again."""
        del self.numbers[self.requests.pop(r).request_id]
        self.task.absent_cost[r] = 0.0
        self._free.append(r)

    # ------------------------------------------------------------ calls

    def add_fixed(self, call: Call) -> int:
        """The node of a call that is made even if no rider boards or alights."""
        node = self._next_fixed
        self._next_fixed += 2
        task = self.task
        early_s = call.leave_from_s - call.dwell_s - self.origin_s
        timed = np.isfinite(early_s)
        task.place[node] = call.place
        self._set_travel_time_factor(node, call.travel_time_factor)
        task.service_s[node] = call.dwell_s
        task.early_s[node] = early_s if timed else -CUT_OFF_S
        late_s = min(call.arrive_by_s - self.origin_s, 0.5 * CUT_OFF_S)
        task.late_s[node] = max(late_s, task.early_s[node])
        task.delay_cost[node] = self.problem.weights.late if timed else 0.0
        self.stays[node] = Stay(call, len(self.stays))
        return node

    def enter_calls(self, vehicle: VehicleState) -> tuple[list[int], int]:
        """The nodes of the calls in order, and how many nodes of the route are locked, its start included."""
        nodes: list[int] = []
        locked = 1
        for number, call in enumerate(vehicle.calls):
            stay = Stay(call, len(self.stays))
            if call.fixed or (number < vehicle.locked and _stands(call)):
                nodes.append(self.add_fixed(call))
            for request_id in call.alight:
                nodes.append(self._known(request_id, call, stay) + 1)
            for request_id in call.board:
                nodes.append(self._known(request_id, call, stay))
            if number < vehicle.locked:
                locked = len(nodes) + 1
        return nodes, locked

    def _known(self, request_id: str, call: Call, stay: Stay) -> int:
        """The pickup node of a request that a call names; the visit there is that call."""
        r = self.numbers[request_id]
        node = 2 * r + (request_id in call.alight)
        self.task.service_s[node] = call.dwell_s
        self._set_travel_time_factor(node, call.travel_time_factor)
        self.stays[node] = stay
        return 2 * r

    def _set_travel_time_factor(self, node: int, travel_time_factor: float) -> None:
        """A request keeps its first travel time factor, so that narrower windows never change its times."""
        self.task.travel_time_factor[node] = travel_time_factor
        if travel_time_factor != 1.0 and not self.task.has_travel_time_factors:
            self.task = self.task._replace(has_travel_time_factors=True)

    def name_of(self, node: int) -> str:
        """The request or the call whose visit it is; "" for the end of a shift."""
        if node < 2 * self.task.requests:
            return self.requests[node >> 1].request_id
        return self.stays[node].call.call_id if node in self.stays else ""

    # ------------------------------------------------------------ vehicles

    def place_vehicle(self, v: int, vehicle: VehicleState) -> None:
        """Write where and when vehicle v starts and ends, what it may carry, and its riders aboard."""
        task, start = self.task, 2 * (self.task.requests + v)
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
        for request_id in vehicle.aboard:
            # A rider aboard has a drop-off only; where it began is behind the vehicle.
            r = self.numbers[request_id]
            task.load[start] += task.load[2 * r]
            task.ride_s_max[2 * r] = np.inf

    def start_at(self, v: int, node: int) -> None:
        """Vehicle v starts where this node is, at the node's earliest time."""
        task, start = self.task, 2 * (self.task.requests + v)
        here, there = task.place[start], task.place[node]
        if self.problem.plane is None:
            task.travel_s[here] = task.travel_s[there]
        else:
            task.xy[here] = task.xy[there]
        task.early_s[start] = task.early_s[node]


def fixed_calls(problem: Problem) -> int:
    """How many calls of the problem have a node of their own."""
    fixed = sum(_stands(call) for vehicle in problem.vehicles for call in vehicle.calls)
    return fixed + sum(len(chain.calls) for chain in problem.open_chains)


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
