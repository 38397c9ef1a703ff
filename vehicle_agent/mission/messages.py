"""Messages of the server, an operator or a phone, and the state after each."""

import msgspec

from contract.roads.network import RoadNetwork
from contract.wire.messages import Command, CommandDone, Grants, Order, OrderRejected, PassengerTap
from contract.wire.reasons import HoldReason
from vehicle_agent.mission import boarding
from vehicle_agent.mission.memory import MissionMemory, StandingAnnouncement, remembered
from vehicle_agent.mission.order_line import LanePoint, OrderLine, VisitUnreachable, locate, order_line
from vehicle_agent.mission.orders import is_repeat, order_accepted, order_rejection, with_order
from vehicle_agent.mission.placing import Placing, placing_result, why_not_placed
from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.mission.sections import OccupiedSection
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import Ego

# A scene is for somebody who looks now: a request that has waited longer is not executed.
SCENE_WITHIN_NS = 10_000_000_000


def take_order(state: MissionState, order: Order, network: RoadNetwork, ego: Ego) -> MissionState:
    """Accepts and follows the order, or rejects it. A repeat is accepted again and changes nothing."""
    if is_repeat(order, state.memory):
        return state.after(answers=(*state.answers, order_accepted(order)))
    if not state.place.lane_id and not ego.valid:
        return state.after(pending_order=order)
    rejection = order_rejection(order, state.memory, network, state.server_now_ns())
    if rejection is not None:
        return state.after(answers=(*state.answers, rejection))
    start = _start(state, network, ego, order.visits[0].route)
    if start is None:
        return state.after(answers=(*state.answers, _not_on_lane(order, state.memory)))
    line_id = state.line_count + 1
    result = with_order(order, state.memory, network, start, line_id)
    if isinstance(result, OrderRejected):
        return state.after(answers=(*state.answers, result))
    memory, route = result
    state = state.after(memory=memory, answers=(*state.answers, order_accepted(order)))
    return on_line(state, route, start)


def on_line(state: MissionState, route: OrderLine, start: LanePoint) -> MissionState:
    """The state with the vehicle on a new line, which begins with the vehicle's lane."""
    temporary = state.temporary
    if temporary is not None:
        # A stop that is being served is where the vehicle stands. One that is not on the new line is dropped.
        s_m = route.s_of(temporary.place, start.s_m - 1.0) if state.stage == "driving" else start.s_m
        temporary = None if s_m is None else msgspec.structs.replace(temporary, s_m=s_m)
    return state.after(
        route=route,
        line_count=route.line_id,
        s_m=start.s_m,
        segment=route.segment_at(start.s_m),
        place=start,
        is_off_route=False,
        temporary=temporary,
        wait_s_m=None,
        hold_s_m=start.s_m if state.standing_since_ns else start.s_m + (state.hold_s_m - state.s_m),
    )


def take_grants(state: MissionState, grants: Grants) -> MissionState:
    """Replaces the grants by the server's list, less the sections released meanwhile."""
    order = state.memory.order
    if order is None or grants.order_id != order.order_id:
        return state
    sections = tuple(grant for grant in grants.sections if grant not in state.memory.released)
    if sections == state.memory.grants:
        return state
    return state.after(memory=msgspec.structs.replace(state.memory, grants=sections))


def execute_command(
    state: MissionState, command: Command, network: RoadNetwork, rules: MissionRules, ego: Ego
) -> MissionState:
    """Holds, stops, resumes, announces, marks the recording, or tries a place; each is executed once.

    A failed one may be repeated.
    """
    if command.command_id in state.memory.heard:
        return state
    detail = ""
    match command.kind:
        case "hold":
            braking_m = ego.speed_mps * rules.hold_reaction_s + ego.speed_mps**2 / (
                2.0 * rules.hold_decel_mps2
            )
            state = _hold(state, "operator_hold", command.text, state.s_m + braking_m)
        case "stop_now":
            state = _hold(state, "operator_stop", command.text, state.s_m)
        case "announce":
            state = _announce(state, command)
        case "resume":
            state, detail = _resume(state, network, rules, ego)
        case "mark" | "start_recording" | "stop_recording":
            pass  # The recorder writes them into the run log.
        case "show_scene" | "show_camera":
            # Pictures come from the process that records video: the link asks it.
            detail = _why_no_scene(state, command)
        case "set_position":
            detail = why_not_placed(command, ego)
            if not detail:
                return _placing(state, command)
    if not detail:
        heard = remembered(state.memory.heard, command.command_id)
        state = state.after(memory=msgspec.structs.replace(state.memory, heard=heard))
    return state.after(CommandDone(command.command_id, not detail, detail))


def _announce(state: MissionState, command: Command) -> MissionState:
    """Says the text; one that stands for a time is also shown, and an empty one takes it down."""
    shown = state.memory.shown
    if not command.text:
        shown = None
    elif command.shown_until_ns:
        shown = StandingAnnouncement(command.text, command.text_zh or command.text, command.shown_until_ns)
    return state.after(
        memory=msgspec.structs.replace(state.memory, shown=shown),
        announcement=command.text,
        announcement_zh=command.text_zh,
        announced_ns=state.stamp_ns,
    )


def answer_placing(state: MissionState, ego: Ego) -> MissionState:
    """Tells what came of the place that an operator named, once that is known."""
    done = None if state.placing is None else placing_result(state.placing, ego, state.stamp_ns)
    if done is None:
        return state
    state = state.after(done, placing=None)
    if not done.done:
        return state
    heard = remembered(state.memory.heard, done.command_id)
    return state.after(memory=msgspec.structs.replace(state.memory, heard=heard))


def take_tap(state: MissionState, message: PassengerTap) -> MissionState:
    memory, seats, events = boarding.take_tap(
        state.memory, state.seats, state.visit_here(), message, state.doors.phase == "open"
    )
    return state.after(*events, memory=memory, seats=seats)


def find_line(
    state: MissionState, network: RoadNetwork, ego: Ego
) -> tuple[MissionState, HoldReason | None, str]:
    """(state with the stored order as a line from here, None, ""); without a line (state, reason, detail)."""
    visits = state.memory.open_visits()
    start = _start(state, network, ego, visits[0].route if visits else ())
    if start is None:
        return state, "off_map", ""
    if not visits:
        return state.after(place=start, is_off_route=False, route=None), None, ""
    try:
        route = order_line(network, visits, start, state.line_count + 1)
    except VisitUnreachable as error:
        return state, "unreachable_visit", str(error)
    if not state.occupied_sections:
        leaving_m = state.odometer_m + 1.0
        occupied_sections = tuple(OccupiedSection(grant, leaving_m) for grant in state.memory.occupied)
        state = state.after(occupied_sections=occupied_sections)
    return on_line(state, route, start), None, ""


def _hold(state: MissionState, reason: HoldReason, detail: str, stop_s_m: float) -> MissionState:
    if state.held:
        return state.after(hold_reason=reason, hold_detail=detail)
    return state.after(held=True, hold_reason=reason, hold_detail=detail, hold_s_m=stop_s_m)


def _resume(
    state: MissionState, network: RoadNetwork, rules: MissionRules, ego: Ego
) -> tuple[MissionState, str]:
    if not ego.valid:
        return state, "the vehicle does not know where it is: wait for a good position, then resume again"
    if state.is_off_route or state.route is None:
        found, reason, detail = find_line(state, network, ego)
        if reason is not None:
            return state, detail or "the vehicle is not on a lane of the map: drive it onto one by hand"
        aside_m = _aside_m(found, ego)
        if aside_m > rules.off_route_m:
            # It would hold again at once, without a word to the operator who has just resumed it.
            return (
                state,
                f"the vehicle stands {aside_m:.1f} m beside its lane: drive it onto the lane by hand",
            )
        state = found
    # The server resumes a vehicle whose hold is over, too: no operator has looked what else it waits for.
    waved_on_ns = state.waved_on_ns if state.held else state.stamp_ns
    return (
        state.after(
            held=False, hold_reason=None, hold_detail="", resumed_ns=state.stamp_ns, waved_on_ns=waved_on_ns
        ),
        "",
    )


def _aside_m(state: MissionState, ego: Ego) -> float:
    """How far beside its line the vehicle is; 0 without a line."""
    if state.route is None:
        return 0.0
    _, d_m, _ = state.route.along(ego.pose_map, state.segment)
    return abs(d_m)


def _placing(state: MissionState, command: Command) -> MissionState:
    """The place is tried from now on. A repeat changes nothing; another place takes over."""
    assert command.pose_map is not None, "a command without a place is refused"
    before = state.placing
    if before is not None and before.command_id == command.command_id:
        return state
    if before is not None:
        state = state.after(CommandDone(before.command_id, False, "another place was named"))
    return state.after(placing=Placing(command.command_id, command.pose_map, state.stamp_ns))


def _why_no_scene(state: MissionState, command: Command) -> str:
    """Why the vehicle does not show its scene, or a camera, now; "" if it does."""
    now_ns = state.server_now_ns()
    if now_ns is None or now_ns - command.made_ns > SCENE_WITHIN_NS:
        return "the request came too late: ask again"
    return ""


def _start(
    state: MissionState, network: RoadNetwork, ego: Ego, expected: tuple[str, ...]
) -> LanePoint | None:
    if state.route is not None and not state.is_off_route:
        return state.place
    return locate(network, ego.pose_map, expected) if ego.valid else None


def _not_on_lane(order: Order, memory: MissionMemory) -> OrderRejected:
    detail = "the vehicle is not on a lane of the map"
    return OrderRejected(order.epoch, order.order_id, order.revision, "unreachable", detail, memory.visits)
