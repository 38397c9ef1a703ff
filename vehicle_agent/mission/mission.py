"""What the vehicle is to do: its order, visit by visit, inside the sections it has been granted."""

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
from vehicle_agent.mission.cabin_events import press
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.mission.messages import (
    find_line,
    obey,
    take_grants,
    take_order,
    take_tap,
)
from vehicle_agent.mission.occupied_stop import heeded
from vehicle_agent.mission.order_line import located
from vehicle_agent.mission.progress import moved, progress
from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.mission.sections import MovementAuthority, footings, leave_to_drive, released
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import (
    STOP_OCCUPIED,
    CabinEvent,
    Ego,
    LinkState,
    MissionMessage,
    Task,
    TaskMode,
    VehicleMotion,
    World,
)

_FREE = MovementAuthority(math.inf, "")


class Mission(msgspec.Struct, frozen=True):
    """Orders, visits, doors, riders, sections and the seat button (docs/vehicle/onboard.md, mission)."""

    network: RoadNetwork
    rules: MissionRules = MissionRules()

    def initial(self, memory: MissionMemory | None = None) -> MissionState:
        """Standing and held. `memory` is what a crash left: order, visits and riders are still there."""
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
        """What to do now. `events` and `answers` of the new state tell what happened in this step."""
        if link is not None and link.connected:
            state = msgspec.structs.replace(state, server_offset_ns=link.server_offset_ns)
        state = moved(state, self.rules, ego)
        state = self._oriented(state, ego)
        for message in messages:
            state = self._received(state, message, ego)
        leave = self._leave(state)
        for event in cabin_events:
            state = press(state, event, self.network, self.rules, leave, ego.speed_mps)
        state = heeded(progress(state, self.rules, ego, world), self.rules, ego, world)
        state = self._released(state)
        return self._task(state, self._leave(state)), state

    def events(self, state: MissionState) -> tuple[VehicleEvent, ...]:
        return state.events

    def answers(self, state: MissionState) -> tuple[OrderAccepted | OrderRejected, ...]:
        return state.answers

    def _oriented(self, state: MissionState, ego: Ego) -> MissionState:
        """With the first good position: find the lane, the remembered order's line, the order that waited."""
        if not ego.valid or state.route is not None:
            return state
        if not state.place.lane_id:
            state, trouble = find_line(state, self.network, ego)
            if trouble:
                return state.after(hold_reason=trouble) if state.held else state
        elif not state.standing_since_ns:
            place = located(self.network, ego.pose_map, ())
            state = state.after(place=place) if place is not None else state
        if state.waiting_order is not None:
            order = state.waiting_order
            state = take_order(state.after(waiting_order=None), order, self.network, ego)
        return state

    def _received(self, state: MissionState, message: MissionMessage, ego: Ego) -> MissionState:
        match message:
            case Order():
                return take_order(state, message, self.network, ego)
            case Grants():
                return take_grants(state, message)
            case Command():
                return obey(state, message, self.network, self.rules, ego)
            case _:
                return take_tap(state, message)

    def _leave(self, state: MissionState) -> MovementAuthority:
        if state.route is None:
            return _FREE
        rules = self.rules
        return leave_to_drive(
            state.route.line.sections, state.memory.grants, state.s_m, rules.body, rules.section_margin_m
        )

    def _released(self, state: MissionState) -> MissionState:
        rules = self.rules
        standing = state.footing
        if state.route is not None and not state.astray:
            standing = footings(
                state.footing,
                state.route.line.sections,
                state.memory.grants,
                state.s_m,
                state.odometer_m,
                rules.body,
            )
        memory, footing, events = released(state.memory, standing, state.odometer_m, rules.release_slack_m)
        return state.after(*events, memory=memory, footing=footing)

    def _task(self, state: MissionState, leave: MovementAuthority) -> Task:
        mode, reason = _mode(state)
        stop_s_m, waiting_for = _stop(state, leave, mode)
        if mode == "drive" and state.wait_s_m is not None and not waiting_for:
            reason = STOP_OCCUPIED
        visit = state.visit()
        temporary = state.temporary
        order = state.memory.order
        named = visit is not None and temporary is None
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
            stop_name=visit.name if visit is not None and named else "",
            stop_name_en=visit.name_en if visit is not None and named else "",
            doors_open=state.doors.commanded_open,
            aboard=tuple(rider.ride_id for rider in state.memory.aboard),
            waiting_for=waiting_for,
            reason=reason,
            resumed_ns=state.resumed_ns,
            announcement=state.announcement,
            announced_ns=state.announced_ns,
            refused_ns=state.refused_ns,
        )


def persistent(state: MissionState) -> MissionMemory:
    """What must be on disk before this tick's answers and events go out; the same object until it changes."""
    return state.memory


def _mode(state: MissionState) -> tuple[TaskMode, str]:
    if state.held:
        return "hold", state.hold_reason
    if state.astray:
        return "hold", "off the route: drive the shuttle back by hand, then resume"
    if state.stage != "driving":
        if state.temporary is None:
            return "dwell", ""
        return "dwell", "people near" if state.near_since_ns else "requested stop"
    if state.target_s_m() is None:
        return "idle", "no order"
    return "drive", "requested stop" if state.temporary is not None else ""


def _stop(state: MissionState, leave: MovementAuthority, mode: TaskMode) -> tuple[float, str]:
    """(where the rear axle must stand, the section that is missing if that is why)."""
    target_s_m = state.target_s_m()
    if mode in ("idle", "dwell") or target_s_m is None:
        return state.s_m, ""
    wanted_m = min(target_s_m, state.hold_s_m) if mode == "hold" and not state.astray else target_s_m
    if mode == "hold" and state.astray:
        wanted_m = state.s_m
    if state.wait_s_m is not None:
        wanted_m = min(wanted_m, state.wait_s_m)
    if leave.hold_s_m < wanted_m:
        return leave.hold_s_m, leave.waiting_for
    return wanted_m, ""
