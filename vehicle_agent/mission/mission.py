"""The mission room: the order, visit by visit, within the granted sections."""

import math

import msgspec

from contract.roads.network import RoadNetwork
from contract.wire.messages import (
    Command,
    Grants,
    Order,
    OrderAccepted,
    OrderRejected,
    VehicleEvent,
)
from contract.wire.reasons import HoldReason
from vehicle_agent.mission.cabin_events import take_cabin_event
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.mission.messages import (
    answer_placing,
    execute_command,
    find_line,
    take_grants,
    take_order,
    take_tap,
)
from vehicle_agent.mission.occupied_stop import wait_for_occupied_stop
from vehicle_agent.mission.order_line import locate
from vehicle_agent.mission.progress import advance_visit, update_position
from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.mission.sections import (
    MovementAuthority,
    find_occupied_sections,
    movement_authority,
    release_sections,
)
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import (
    CabinEvent,
    Ego,
    LinkState,
    MissionMessage,
    Task,
    TaskMode,
    TaskReason,
    VehicleMotion,
    World,
)

_FREE = MovementAuthority(math.inf, "")


class Mission(msgspec.Struct, frozen=True):
    """Orders, visits, doors, riders, sections and the seat button (docs/vehicle/mission.md)."""

    network: RoadNetwork
    rules: MissionRules

    def initial(self, memory: MissionMemory | None = None) -> MissionState:
        """Standing and held. memory: order, visits and riders as they were before a crash."""
        return MissionState(memory or MissionMemory())

    def step(
        self,
        state: MissionState,
        messages: tuple[MissionMessage, ...],
        cabin_events: tuple[CabinEvent, ...],
        link: LinkState | None,
        ego: Ego,
        motion: VehicleMotion,
        world: World,
        now_ns: int,
    ) -> tuple[Task, MissionState]:
        """The task now. `events` and `answers` of the new state are those of this step."""
        if link is not None and link.connected:
            state = msgspec.structs.replace(state, server_offset_ns=link.server_offset_ns)
        state = update_position(state, self.rules, ego)
        state = self._with_position(state, ego)
        for message in messages:
            state = self._take_message(state, message, ego)
        state = answer_placing(state, ego)
        authority = self._authority(state)
        for event in cabin_events:
            state = take_cabin_event(state, event, self.network, self.rules, authority, ego.speed_mps)
        state = wait_for_occupied_stop(advance_visit(state, self.rules, ego, world), self.rules, ego, world)
        state = self._with_sections_released(state)
        return self._task(state, self._authority(state)), state

    def events(self, state: MissionState) -> tuple[VehicleEvent, ...]:
        return state.events

    def answers(self, state: MissionState) -> tuple[OrderAccepted | OrderRejected, ...]:
        return state.answers

    def _with_position(self, state: MissionState, ego: Ego) -> MissionState:
        """With a valid position: finds the lane and the stored order's line, and takes a pending order."""
        if not ego.valid or state.route is not None:
            return state
        if not state.place.lane_id:
            state, reason, detail = find_line(state, self.network, ego)
            if reason is not None:
                return state.after(hold_reason=reason, hold_detail=detail) if state.held else state
        elif not state.standing_since_ns:
            place = locate(self.network, ego.pose_map, ())
            state = state.after(place=place) if place is not None else state
        if state.pending_order is not None:
            order = state.pending_order
            state = take_order(state.after(pending_order=None), order, self.network, ego)
        return state

    def _take_message(self, state: MissionState, message: MissionMessage, ego: Ego) -> MissionState:
        match message:
            case Order():
                return take_order(state, message, self.network, ego)
            case Grants():
                return take_grants(state, message)
            case Command():
                return execute_command(state, message, self.network, self.rules, ego)
            case _:
                return take_tap(state, message)

    def _authority(self, state: MissionState) -> MovementAuthority:
        if state.route is None:
            return _FREE
        rules = self.rules
        return movement_authority(
            state.route.line.sections, state.memory.grants, state.s_m, rules.body, rules.section_margin_m
        )

    def _with_sections_released(self, state: MissionState) -> MissionState:
        rules = self.rules
        standing = state.occupied_sections
        if state.route is not None and not state.is_off_route:
            standing = find_occupied_sections(
                state.occupied_sections,
                state.route.line.sections,
                state.memory.grants,
                state.s_m,
                state.odometer_m,
                rules.body,
            )
        memory, occupied_sections, events = release_sections(
            state.memory, standing, state.odometer_m, rules.release_slack_m
        )
        return state.after(*events, memory=memory, occupied_sections=occupied_sections)

    def _task(self, state: MissionState, authority: MovementAuthority) -> Task:
        mode, reason = _mode(state)
        hold_reason, hold_detail = _hold_reason(state)
        stop_s_m, waiting_for = _stop(state, authority, mode)
        if mode == "drive" and state.wait_s_m is not None and not waiting_for:
            reason = "stop_occupied"
        visit = state.visit()
        temporary = state.temporary
        order = state.memory.order
        named = visit if temporary is None else None
        return Task(
            mode=mode,
            line=None if state.route is None else state.route.line,
            line_id=0 if state.route is None else state.route.line_id,
            s_m=state.s_m,
            d_m=state.d_m,
            stop_s_m=stop_s_m,
            lane_id=state.place.lane_id,
            lane_s_m=state.place.s_m,
            order_id="" if order is None else order.order_id,
            revision=0 if order is None else order.revision,
            visit_id=temporary.visit_id if temporary else visit.visit_id if visit else "",
            stop_name="" if named is None else named.name,
            stop_name_en="" if named is None else named.name_en,
            doors_open=state.doors.commanded_open,
            aboard=tuple(rider.ride_id for rider in state.memory.aboard),
            waiting_for=waiting_for,
            reason=reason,
            hold_reason=hold_reason,
            hold_detail=hold_detail,
            resumed_ns=state.resumed_ns,
            waved_on_ns=state.waved_on_ns,
            announcement=state.announcement,
            announcement_zh=state.announcement_zh,
            announced_ns=state.announced_ns,
            refused_ns=state.refused_ns,
            utc_ns=state.server_now_ns() or 0,
        )


def _hold_reason(state: MissionState) -> tuple[HoldReason | None, str]:
    """(why the vehicle holds, None when it does not; what people have to know besides)."""
    if state.held:
        return state.hold_reason, state.hold_detail
    if state.is_off_route:
        return "off_route", ""
    return None, ""


def _mode(state: MissionState) -> tuple[TaskMode, TaskReason | None]:
    if state.held or state.is_off_route:
        return "hold", None
    if state.stage != "driving":
        if state.temporary is None:
            return "dwell", None
        return "dwell", "people_near" if state.near_since_ns else "requested_stop"
    if state.target_s_m() is None:
        return "idle", "no_order"
    return "drive", "requested_stop" if state.temporary is not None else None


def _stop(state: MissionState, authority: MovementAuthority, mode: TaskMode) -> tuple[float, str]:
    """(where the rear axle must stop, the section without a grant if that is the reason)."""
    target_s_m = state.target_s_m()
    if mode in ("idle", "dwell") or target_s_m is None:
        return state.s_m, ""
    wanted_m = min(target_s_m, state.hold_s_m) if mode == "hold" and not state.is_off_route else target_s_m
    if mode == "hold" and state.is_off_route:
        wanted_m = state.s_m
    if state.wait_s_m is not None:
        wanted_m = min(wanted_m, state.wait_s_m)
    if authority.hold_s_m < wanted_m:
        return authority.hold_s_m, authority.waiting_for
    return wanted_m, ""
