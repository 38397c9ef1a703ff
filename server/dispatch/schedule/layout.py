"""A route of the engine's nodes as a vehicle's calls. Riders at one place share a call.

A party whose pickup opens much later has a call of its own: else those who get off or on before would wait
for it, and the vehicle would block the road there. Between the two calls it can rest elsewhere.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from server.dispatch.engine.plan import Plan
from server.dispatch.engine.task import Task, drive_s
from server.dispatch.problem import Call, CallTime, Request

# A vehicle waits at a place for at most so long. Calls that are apart already are joined at half of it, so
# that they do not change with every second of the expected times.
WAIT_S_MAX = 300.0


@dataclass(frozen=True, slots=True)
class Stay:
    """The call that a node belonged to when the schedule was filled; number tells calls apart."""

    call: Call
    number: int


def _off_duty(stay: Stay | None) -> bool:
    return stay is not None and stay.call.off_duty


@dataclass(slots=True)
class _Group:
    place: int
    locked: bool
    travel_time_factor: float
    stay: Stay | None = None
    board: list[str] = field(default_factory=list)
    alight: list[str] = field(default_factory=list)
    arrive_s: float = 0.0
    leave_s: float = 0.0
    dwell_s: float = 0.0

    def takes(self, place: int, locked: bool, stay: Stay | None, wait_s: float) -> bool:
        """Whether a node right after those of the group is part of the same call.

        wait_s  how long the vehicle would wait for it
        """
        if place != self.place or locked != self.locked or _off_duty(stay) or _off_duty(self.stay):
            return False
        is_apart = stay is not None and self.stay is not None and stay.number != self.stay.number
        if not locked and wait_s > (0.5 * WAIT_S_MAX if is_apart else WAIT_S_MAX):
            return False
        if stay is None or self.stay is None or not is_apart:
            return True
        return not (stay.call.fixed or self.stay.call.fixed or locked)


def calls_and_times(
    task: Task,
    plan: Plan,
    v: int,
    stays: Mapping[int, Stay],
    requests: Mapping[int, Request],
    origin_s: float,
) -> tuple[tuple[Call, ...], tuple[CallTime, ...]]:
    """A vehicle's calls in order with their times.

    A call that was there keeps its name; where its riders have come apart the first part keeps it.
    """
    groups: list[_Group] = []
    route = plan.route[v]
    for k in range(1, int(plan.length[v]) - 1):
        node = int(route[k])
        stay, locked = stays.get(node), k < plan.locked[v]
        is_pickup = node < 2 * task.requests and not node & 1
        wait_s = float(plan.least_s[v, k]) - groups[-1].leave_s if groups and is_pickup else 0.0
        if not groups or not groups[-1].takes(int(task.place[node]), locked, stay, wait_s):
            left_s = groups[-1].leave_s if groups else float(plan.least_s[v, 0])
            arrive_s = left_s + float(drive_s(task, route[k - 1], node))
            travel_time_factor = float(task.travel_time_factor[node])
            groups.append(
                _Group(int(task.place[node]), locked, travel_time_factor, arrive_s=arrive_s, leave_s=arrive_s)
            )
        group = groups[-1]
        if stay is not None and (group.stay is None or stay.call.fixed):
            group.stay = stay
        if node < 2 * task.requests:
            (group.alight if node & 1 else group.board).append(requests[node >> 1].request_id)
        group.dwell_s = max(group.dwell_s, float(task.service_s[node]))
        group.leave_s = max(
            group.leave_s, group.arrive_s + group.dwell_s, float(plan.least_s[v, k] + task.service_s[node])
        )
    named: set[int] = set()
    calls = tuple(_call(group, named) for group in groups)
    return calls, tuple(CallTime(g.arrive_s + origin_s, g.leave_s + origin_s) for g in groups)


def _call(group: _Group, named: set[int]) -> Call:
    board, alight = tuple(group.board), tuple(group.alight)
    if group.stay is None or group.stay.number in named:
        return Call(group.place, board, alight, group.dwell_s, travel_time_factor=group.travel_time_factor)
    named.add(group.stay.number)
    was = group.stay.call
    return Call(
        group.place,
        board,
        alight,
        group.dwell_s,
        was.leave_from_s,
        was.arrive_by_s,
        was.fixed,
        was.call_id,
        group.travel_time_factor,
        was.off_duty,
    )
