"""Roads that operators close and open, and the effects on the fleet."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from server.domain.errors import ClosureUnknown, LaneUnknown, SectionUnknown
from server.domain.rides.effects import Effects
from server.domain.rides.rides import RideState
from server.domain.roads.closures import (
    Closure,
    ClosureState,
    due,
    lifted,
    require_sound,
)
from server.usecases.fleet import detours
from server.usecases.planning import plans, unreachable_rides
from server.usecases.planning.effects import effects_since, observe_fleet
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.server_events import record_event

_PROMISED = (RideState.REQUESTED, RideState.ASSIGNED)


@dataclass(frozen=True, slots=True)
class CloseRoad:
    """An operator's request. starts_at None means now, ends_at None until it is lifted."""

    lane_ids: tuple[str, ...] = ()
    section_ids: tuple[str, ...] = ()
    reason: str = ""
    starts_at: datetime | None = None
    ends_at: datetime | None = None


def close(uow: UnitOfWork, request: CloseRoad, by: str) -> Closure:
    """Close a road: from its beginning on no vehicle is sent there. Affected rides change at once.

    Raises LaneUnknown, SectionUnknown, ClosureInvalid, CampusUnknown.
    """
    network = uow.network()
    for lane_id in request.lane_ids:
        if lane_id not in network.lanes:
            raise LaneUnknown(f"the map has no lane {lane_id}")
    for section_id in request.section_ids:
        if section_id not in network.sections:
            raise SectionUnknown(f"the map has no section {section_id}")
    closure = Closure(
        uow.campus_id,
        uow.ids.new_id("closure"),
        tuple(dict.fromkeys(request.lane_ids)),
        tuple(dict.fromkeys(request.section_ids)),
        request.reason,
        request.starts_at or uow.now,
        request.ends_at,
        by,
        uow.now,
    )
    require_sound(closure)
    uow.closures.add(closure)
    _record_and_publish(uow, "road.closed", closure, by)
    uow.roads_changed()
    _begin_and_end(uow)
    keep_reachable(uow)
    plans.assign_waiting(uow)
    return uow.closures.get(closure.closure_id) or closure


def close_with_effects(uow: UnitOfWork, request: CloseRoad, by: str) -> Effects:
    """Close a road. Returns the effects on rides and departures; rolled back, it is its own preview.

    Raises LaneUnknown, SectionUnknown, ClosureInvalid, CampusUnknown.
    """
    fleet = observe_fleet(uow)
    close(uow, request, by)
    return effects_since(uow, fleet)


def lift(uow: UnitOfWork, closure_id: str, by: str) -> Closure:
    """The road is open again, or will not be closed. Raises ClosureUnknown, ClosureOver."""
    closure = uow.closures.get(closure_id)
    if closure is None:
        raise ClosureUnknown(f"there is no closure {closure_id}")
    gone = lifted(closure, by)
    uow.closures.save(gone)
    _record_and_publish(uow, "road.opened", gone, by)
    _wake_dispatcher(uow)
    return gone


def update_closures(uow: UnitOfWork) -> None:
    """Begin and end closures whose time has come, and change the plans that they affect."""
    if not uow.has_closures():
        return
    if _begin_and_end(uow):
        keep_reachable(uow)


def keep_reachable(uow: UnitOfWork) -> None:
    """Change the plans and rides that closed roads cut off now: vehicles drive on, and new rides come."""
    if not uow.has_closures():
        return
    standing = uow.closures.standing()
    if any(closure.state is ClosureState.IN_FORCE for closure in standing):
        detours.reroute_vehicles(uow, standing)
    if any(closure.state is ClosureState.SCHEDULED for closure in standing):
        _postpone_cut_off_rides(uow, standing)


def _begin_and_end(uow: UnitOfWork) -> bool:
    """Whether a closure has begun or ended."""
    before = uow.closures.standing()
    now = [due(closure, uow.now) for closure in before]
    changed = [closure for closure, was in zip(now, before, strict=True) if closure.state is not was.state]
    for closure in changed:
        uow.closures.save(closure)
        in_force = closure.state is ClosureState.IN_FORCE
        _record_and_publish(uow, "road.closure_began" if in_force else "road.opened", closure, "")
    if changed:
        uow.roads_changed()
    if any(closure.state is ClosureState.OVER for closure in changed):
        _wake_dispatcher(uow)
    return bool(changed)


def _wake_dispatcher(uow: UnitOfWork) -> None:
    """Waiting rides may get a vehicle now: wake the dispatcher."""
    uow.roads_changed()
    uow.publish(topics.dispatch(uow.campus_id))
    uow.publish(topics.sections(uow.campus_id))


def _postpone_cut_off_rides(uow: UnitOfWork, standing: Sequence[Closure]) -> None:
    """Postpone rides that a closure will cut off at their time, before it begins."""
    concerned = [
        ride
        for ride in uow.rides.in_states(_PROMISED)
        if unreachable_rides.will_be_cut_off(uow, ride, standing)
    ]
    for vehicle_id in unreachable_rides.postpone(uow, concerned):
        detours.replan(uow, vehicle_id)


def _record_and_publish(uow: UnitOfWork, name: str, closure: Closure, by: str) -> None:
    roads = ", ".join((*closure.lane_ids, *closure.section_ids))
    detail = f"{roads}: {closure.reason}" if closure.reason else roads
    record_event(uow, name, closure.closure_id, by, detail)
    uow.publish(topics.closures(uow.campus_id), closure_id=closure.closure_id, state=str(closure.state))
