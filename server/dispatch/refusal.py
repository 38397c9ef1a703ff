"""Names the rule that keeps a request from being carried."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.decide import offers_for
from server.dispatch.engine.task import SEATS, WHEELCHAIRS
from server.dispatch.problem import CUT_OFF_S, Request
from server.dispatch.schedule.schedule import Schedule

NO_VEHICLE, SEATS_RULE, WHEELCHAIR, WINDOW = "no_vehicle_free", "seats", "wheelchair", "pickup_window"
RIDE_TIME, ARRIVAL, TIMETABLE, BATTERY, CLOSED = "ride_time", "arrival", "timetable", "battery", "closed_road"
RULES = (NO_VEHICLE, SEATS_RULE, WHEELCHAIR, WINDOW, RIDE_TIME, ARRIVAL, TIMETABLE, BATTERY, CLOSED)
# In this order, the first rule without which a vehicle could carry the request is the one that binds. With
# more time nearly every request passes, so the window comes last. A shuttle off duty is not free.
_LIFTED = (NO_VEHICLE, SEATS_RULE, WHEELCHAIR, RIDE_TIME, ARRIVAL, TIMETABLE, BATTERY, WINDOW)


def binding_rule(schedule: Schedule, request_id: str) -> str:
    """One of RULES, for a request of the schedule that no vehicle can carry.

    Rules that no time can change are tested first. Then each of the others is lifted alone. If no single one
    helps, the pickup window is named.
    """
    task, r = schedule.task, schedule.rows[request_id]
    request = schedule.requests[r]
    able = schedule.accepts
    if not able.any():
        return NO_VEHICLE
    able = able & (task.capacity[:, SEATS] >= request.party)
    if not able.any():
        return SEATS_RULE
    able = able & (task.capacity[:, WHEELCHAIRS] >= request.wheelchairs)
    if not able.any():
        return WHEELCHAIR
    starts = 2 * (task.requests + np.flatnonzero(able))
    to_pickup_s = task.travel_s[task.place[starts], request.pickup]
    if task.travel_s[request.pickup, request.dropoff] >= CUT_OFF_S or to_pickup_s.min() >= CUT_OFF_S:
        return CLOSED
    for rule in _applicable_rules(schedule, request):
        with _rule_lifted(schedule, r, rule):
            if offers_for(schedule, request_id).best is not None:
                return rule
    return WINDOW


def _applicable_rules(schedule: Schedule, request: Request) -> list[str]:
    """The rules that can apply here, in the order in which they are tested."""
    idle = {
        NO_VEHICLE: not _on_shifts(schedule).any(),
        WHEELCHAIR: request.wheelchairs == 0,
        RIDE_TIME: np.isinf(request.ride_s_max),
        ARRIVAL: np.isinf(request.arrive_by_s),
        TIMETABLE: not len(schedule.task.late_s[_fixed(schedule)]),
        BATTERY: bool(np.isinf(schedule.task.drive_s_max).all()),
    }
    return [rule for rule in _LIFTED if not idle.get(rule, False)]


def _on_shifts(schedule: Schedule) -> AnyArray:
    """(V,) bool: vehicles with shifts."""
    task = schedule.task
    ends = slice(2 * task.requests + 1, 2 * (task.requests + task.vehicles), 2)
    return np.asarray(task.late_s[ends] < CUT_OFF_S)


def _without_shifts(schedule: Schedule) -> None:
    """Every vehicle is on duty all the time."""
    task = schedule.task
    starts = 2 * (task.requests + np.flatnonzero(_on_shifts(schedule)))
    task.early_s[starts] = -CUT_OFF_S
    task.late_s[starts + 1] = CUT_OFF_S
    off = schedule.off_duty_nodes()
    task.early_s[off], task.late_s[off] = -CUT_OFF_S, CUT_OFF_S
    task.service_s[off] = 0.0


def _fixed(schedule: Schedule) -> slice:
    """The nodes of timed calls."""
    return slice(2 * (schedule.task.requests + schedule.task.vehicles), None, 2)


@contextmanager
def _rule_lifted(schedule: Schedule, r: int, rule: str) -> Iterator[None]:
    """The schedule with one rule lifted; the rule is restored at the end."""
    task, request = schedule.task, schedule.requests[r]
    kept = task.load[2 * r : 2 * r + 2].copy()
    drive_s_max = task.drive_s_max.copy()
    fixed = _fixed(schedule)
    early_s, late_s = task.early_s[fixed].copy(), task.late_s[fixed].copy()
    service_s = task.service_s[fixed].copy()
    duty = slice(2 * task.requests, 2 * (task.requests + task.vehicles))
    duty_s = task.early_s[duty].copy(), task.late_s[duty].copy()
    schedule.write(r, _request_without(request, rule))
    if rule == SEATS_RULE:
        task.load[2 * r : 2 * r + 2, SEATS] = 0
    elif rule == WHEELCHAIR:
        task.load[2 * r : 2 * r + 2, WHEELCHAIRS] = 0
    elif rule == BATTERY:
        task.drive_s_max[:] = np.inf
    elif rule == TIMETABLE:
        task.late_s[fixed] += CUT_OFF_S
        schedule.retime()
    elif rule == NO_VEHICLE:
        _without_shifts(schedule)
        schedule.retime()
    try:
        yield
    finally:
        schedule.write(r, request)
        task.load[2 * r : 2 * r + 2] = kept
        task.drive_s_max[:] = drive_s_max
        if rule in (TIMETABLE, NO_VEHICLE):
            task.early_s[fixed], task.late_s[fixed] = early_s, late_s
            task.service_s[fixed] = service_s
            task.early_s[duty], task.late_s[duty] = duty_s
            schedule.retime()


def _request_without(request: Request, rule: str) -> Request:
    far_s = request.pickup_from_s + 0.25 * CUT_OFF_S
    if rule == WINDOW:
        return replace(request, pickup_to_s=far_s)
    if rule == ARRIVAL:
        return replace(request, arrive_by_s=far_s)
    if rule == RIDE_TIME:
        return replace(request, ride_s_max=far_s)
    return request
