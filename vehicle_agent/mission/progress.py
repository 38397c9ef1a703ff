"""Arrival, dwell and departure at a visit or a temporary stop."""

import math

import msgspec

from contract.wire.messages import Blocked, DoorsChanged, VehicleEvent, Visit, VisitChanged
from vehicle_agent.mission import boarding
from vehicle_agent.mission.boarding import SeatState
from vehicle_agent.mission.departure import nearest_hindrance_m
from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import Ego, World


def advance_visit(state: MissionState, rules: MissionRules, ego: Ego, world: World) -> MissionState:
    """The state after one tick of arriving, serving or leaving a stop."""
    state = update_doors(state, rules)
    match state.stage:
        case "driving":
            return _check_arrival(state, rules)
        case "serving":
            return _serve(state, rules, ego)
        case "leaving":
            return _leave_stop(state, rules, ego, world)


def is_standing(state: MissionState, rules: MissionRules) -> bool:
    """At rest for at least standing_ns."""
    return 0 < state.standing_since_ns <= state.stamp_ns - rules.standing_ns


def update_doors(state: MissionState, rules: MissionRules) -> MissionState:
    """Takes the doors as open or closed as soon as they are, and reports a change."""
    doors = state.doors.step(state.stamp_ns, rules.door_travel_ns)
    if doors.phase == state.doors.phase:
        return state.after(doors=doors)
    visit = state.visit()
    visit_id = state.temporary.visit_id if state.temporary else visit.visit_id if visit else ""
    is_open = doors.phase == "open"
    return state.after(
        DoorsChanged(is_open, visit_id),
        doors=doors,
        doors_open_ns=state.stamp_ns if is_open else state.doors_open_ns,
        seats=state.seats if is_open else SeatState(state.seats.occupied),
    )


def _check_arrival(state: MissionState, rules: MissionRules) -> MissionState:
    target_s_m = state.target_s_m()
    if target_s_m is None or state.held or state.is_off_route or not is_standing(state, rules):
        return state
    left_m = target_s_m - state.s_m
    if not -rules.overshot_m <= left_m <= rules.arrived_m:
        return state
    if left_m > rules.docked_m and state.stamp_ns - state.standing_since_ns < rules.creep_ns:
        # A vehicle that has stopped short drives on to the stop, if nothing hinders it.
        return state
    if state.temporary is not None:
        return _open_doors(state)
    visit = state.visit()
    assert visit is not None
    if state.memory.visit_state(visit.visit_id) == "pending":
        state = state.after(
            VisitChanged(visit.visit_id, visit.stop_id, "under_way"),
            *boarding.told_again(state.memory, visit),
            memory=state.memory.with_visit(visit.visit_id, "under_way"),
        )
    if visit.kind == "rest" and not visit.board and not visit.alight:
        return _finish_visit(state, visit)
    return _open_doors(state)


def _open_doors(state: MissionState) -> MissionState:
    return state.after(stage="serving", doors=state.doors.command(True, state.stamp_ns), doors_open_ns=0)


def _serve(state: MissionState, rules: MissionRules, ego: Ego) -> MissionState:
    """Keeps the doors open until the dwell is over; closes them at once if the vehicle moves."""
    if ego.speed_mps < rules.rolling_mps and not _dwell_is_over(state, rules):
        return state
    visit = state.visit_here()
    memory, events = boarding.close_visit(state.memory, visit)
    return state.after(
        *events,
        memory=memory,
        stage="leaving",
        doors=state.doors.command(False, state.stamp_ns),
        near_since_ns=0,
        clear_since_ns=0,
    )


def _dwell_is_over(state: MissionState, rules: MissionRules) -> bool:
    if state.doors.phase != "open" or state.held:
        return False
    open_ns = state.stamp_ns - state.doors_open_ns
    if state.temporary is not None:
        return open_ns >= rules.temporary_dwell_ns
    visit = state.visit()
    if visit is None:
        return True
    if open_ns < round(visit.dwell_s * 1e9):
        return False
    server_now_ns = state.server_now_ns()
    is_early = server_now_ns is not None and server_now_ns < visit.not_before_ns
    if is_early and (visit.timed or boarding.riders_to_board(visit, state.memory)):
        return False
    late_ns = open_ns - round(visit.dwell_s * 1e9)
    return late_ns >= rules.alight_grace_ns or not _expected_to_alight(state, visit)


def _expected_to_alight(state: MissionState, visit: Visit) -> bool:
    return any(
        rider.ride_id not in state.memory.overdue for rider in boarding.riders_to_alight(visit, state.memory)
    )


def _leave_stop(state: MissionState, rules: MissionRules, ego: Ego, world: World) -> MissionState:
    if state.doors.phase != "closed" or state.doors.sensed is True:
        return state
    if state.temporary is None:
        visit = state.visit()
        at_it = visit is not None and state.memory.visit_state(visit.visit_id) == "under_way"
        return _finish_visit(state, visit) if visit is not None and at_it else state.after(stage="driving")
    hindrance_m = nearest_hindrance_m(world, ego, rules)
    near_since_ns = state.near_since_ns or state.stamp_ns
    clear_since_ns = 0 if math.isfinite(hindrance_m) else state.clear_since_ns or state.stamp_ns
    is_clear = clear_since_ns > 0 and state.stamp_ns - clear_since_ns >= rules.near_clear_ns
    if is_clear or state.waved_on_ns > near_since_ns:
        cleared = (Blocked(near_since_ns, True, 0.0, ego.pose_map),) if state.near_reported else ()
        return state.after(
            *cleared, stage="driving", temporary=None, near_since_ns=0, clear_since_ns=0, near_reported=False
        )
    state = state.after(near_since_ns=near_since_ns, clear_since_ns=clear_since_ns)
    if state.near_reported or clear_since_ns or state.stamp_ns - near_since_ns < rules.near_report_ns:
        return state
    return state.after(Blocked(near_since_ns, False, hindrance_m, ego.pose_map), near_reported=True)


def _finish_visit(state: MissionState, visit: Visit) -> MissionState:
    event: VehicleEvent = VisitChanged(visit.visit_id, visit.stop_id, "done")
    return state.after(event, memory=state.memory.with_visit(visit.visit_id, "done"), stage="driving")


def update_position(state: MissionState, rules: MissionRules, ego: Ego) -> MissionState:
    """Odometer, standing time, and the rear axle's place on the line."""
    travelled_m = 0.0
    if state.stamp_ns:
        travelled_m = abs(ego.speed_mps) * (ego.stamp_ns - state.stamp_ns) * 1e-9
    standing = abs(ego.speed_mps) < rules.standing_mps
    state = msgspec.structs.replace(
        state,
        events=(),
        answers=(),
        stamp_ns=ego.stamp_ns,
        odometer_m=state.odometer_m + travelled_m,
        standing_since_ns=(state.standing_since_ns or ego.stamp_ns) if standing else 0,
    )
    if state.route is None or not ego.valid:
        return state
    s_m, d_m, segment = state.route.along(ego.pose_map, state.segment)
    return msgspec.structs.replace(
        state,
        s_m=s_m,
        d_m=d_m,
        segment=segment,
        place=state.route.place(s_m),
        is_off_route=state.is_off_route or abs(d_m) > rules.off_route_m,
    )
