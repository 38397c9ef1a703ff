"""Cabin events: seat buttons, calls for help, codes, destinations, seat counts and doors."""

from contract.roads.network import RoadNetwork
from contract.wire.messages import HelpRequested, SeatButtonPressed
from vehicle_agent.mission import boarding
from vehicle_agent.mission.progress import update_doors
from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.mission.seat_button import TemporaryStop, next_stopping_place
from vehicle_agent.mission.sections import MovementAuthority
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import (
    CabinEvent,
    CodeTyped,
    DestinationChoice,
    DoorState,
    HelpButton,
    SeatSensor,
)


def take_cabin_event(
    state: MissionState,
    item: CabinEvent,
    network: RoadNetwork,
    rules: MissionRules,
    authority: MovementAuthority,
    speed_mps: float,
) -> MissionState:
    """The state after one cabin event."""
    is_open = state.doors.phase == "open"
    match item:
        case DoorState():
            # At once: a rider who boards in this very tick boards through an open door.
            return update_doors(state.after(doors=state.doors.sense(item.open)), rules)
        case SeatSensor():
            memory, seats, events = boarding.take_seat_count(
                state.memory, state.seats, state.visit_here(), item.occupied, is_open
            )
            return state.after(*events, memory=memory, seats=seats)
        case CodeTyped():
            memory, seats, events = boarding.take_code(
                state.memory, state.seats, state.visit_here(), item.code, is_open
            )
            return state.after(*events, memory=memory, seats=seats)
        case HelpButton():
            return state.after(HelpRequested(item.seat))
        case DestinationChoice():
            visit_id = "" if (visit := state.visit_here()) is None else visit.visit_id
            known = item.stop_id in network.stops
            return state.after(
                boarding.take_destination(state.memory, visit_id, item.code, item.stop_id if known else "")
            )
        case _:
            return _seat_button(state, item.seat, network, rules, authority, speed_mps)


def _seat_button(
    state: MissionState,
    seat: int,
    network: RoadNetwork,
    rules: MissionRules,
    authority: MovementAuthority,
    speed_mps: float,
) -> MissionState:
    visit, route = state.visit(), state.route
    if state.temporary is not None:
        stop = state.temporary
        return state.after(SeatButtonPressed(seat, True, stop.visit_id, stop.place.lane_id, stop.place.s_m))
    s_m, reason = _temporary_stop_s_m(state, network, rules, authority, speed_mps)
    if s_m is None or route is None:
        visit_id = "" if visit is None else visit.visit_id
        # At a stop or while held, the screen already shows the reason.
        on_the_way = state.stage == "driving" and not state.held and visit is not None
        return state.after(
            SeatButtonPressed(seat, False, visit_id, state.place.lane_id, state.place.s_m, reason),
            refused_ns=state.stamp_ns if on_the_way else state.refused_ns,
        )
    number = state.temporaries + 1
    visit_id = f"temporary-{state.stamp_ns}-{number}"
    place = route.place(s_m)
    return state.after(
        SeatButtonPressed(seat, True, visit_id, place.lane_id, place.s_m),
        temporary=TemporaryStop(visit_id, seat, place, s_m),
        temporaries=number,
    )


def _temporary_stop_s_m(
    state: MissionState,
    network: RoadNetwork,
    rules: MissionRules,
    authority: MovementAuthority,
    speed_mps: float,
) -> tuple[float | None, str]:
    """(where on the route the shuttle can stop before its next stop; why it cannot)."""
    visit_s_m = state.target_s_m()
    if state.visit() is None or state.route is None or visit_s_m is None:
        return None, "the shuttle has nowhere to drive"
    if state.stage != "driving":
        return None, "the shuttle stands at a stop"
    if state.held or state.is_off_route:
        return None, "the shuttle is held"
    limit_m = min(authority.hold_s_m, visit_s_m - rules.stops.before_stop_m)
    s_m = next_stopping_place(network, state.route, state.s_m, speed_mps, limit_m, rules.body, rules.stops)
    return s_m, "" if s_m is not None else "no place to stop lies before the next stop"
