"""Stores and applies the events of vehicles: each event once, in order."""

from collections.abc import Sequence
from datetime import timedelta
from typing import NamedTuple

from contract.wire.messages import (
    Blocked,
    CodeRefused,
    CommandDone,
    DestinationRequested,
    DoorsChanged,
    FaultRaised,
    HelpRequested,
    LocalizationMapFailed,
    LocalizationMapStored,
    MapChangeFailed,
    ModeChanged,
    RiderAlighted,
    RiderBoarded,
    RiderDidNotAlight,
    RiderNoShow,
    ScansReported,
    SeatButtonPressed,
    SectionReleased,
    TapAnswered,
    VisitChanged,
)
from contract.wire.sequence import SequenceGap, is_new
from server.domain.errors import SessionFenced, VehicleUnknown
from server.domain.fleet.vehicles import Vehicle
from server.domain.planning.plans import PlannedVisit
from server.domain.record.events import RecordedEvent
from server.domain.rides.rides import WAITING, RideState
from server.usecases.fleet import cabin_requests, conditions, localization_changes, map_changes, scans
from server.usecases.orders import orders, sections, visits
from server.usecases.planning import plans
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.ports.vehicles import EventStore
from server.usecases.record import recordings
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.rides import boarding

# A vehicle's word refreshes when it was heard; a difference this small is not worth a write.
HEARD_WITHIN = timedelta(seconds=0.5)


class EventResult(NamedTuple):
    """is_new is False for a repeat. next_sequence: every event of the boot below it is stored."""

    is_new: bool
    next_sequence: int


class SessionEvent(NamedTuple):
    """An event, and the epoch of the session in which it came."""

    epoch: int
    event: RecordedEvent


def store_event(events: EventStore, event: RecordedEvent) -> bool:
    """Store the event; False when it was stored before, so that its effects are not repeated.

    Raises SequenceGap when an earlier event of the boot is missing.
    """
    if not is_new(events.count(event.vehicle_id, event.boot_id), event.boot_id, event.sequence):
        return False
    events.add(event)
    return True


def apply_event(uow: UnitOfWork, event: RecordedEvent) -> EventResult:
    """Store the event and apply it once. Raises SequenceGap, VehicleUnknown."""
    return _apply(uow, enrolled_vehicle(uow, event.vehicle_id), event)


def apply_events(
    uow: UnitOfWork, events: Sequence[SessionEvent]
) -> tuple[EventResult | SequenceGap | SessionFenced | VehicleUnknown, ...]:
    """Apply events of many vehicles, each once and in this order: a result for each one.

    What one vehicle may not report is its own result, and changes nothing for the others.
    """
    return tuple(_result(uow, one) for one in events)


def _result(
    uow: UnitOfWork, reported: SessionEvent
) -> EventResult | SequenceGap | SessionFenced | VehicleUnknown:
    event = reported.event
    vehicle = uow.vehicles.get(event.vehicle_id)
    if vehicle is None:
        return VehicleUnknown(f"no vehicle {event.vehicle_id} is enrolled")
    if vehicle.epoch != reported.epoch:
        return SessionFenced(f"a newer session of {event.vehicle_id} took over from epoch {reported.epoch}")
    try:
        return _apply(uow, vehicle, event)
    except SequenceGap as gap:
        return gap


def _apply(uow: UnitOfWork, vehicle: Vehicle, event: RecordedEvent) -> EventResult:
    if not store_event(uow.events, event):
        return EventResult(False, uow.events.count(event.vehicle_id, event.boot_id))
    _note_heard(uow, event.vehicle_id)
    _take_effect(uow, vehicle, event)
    if not isinstance(event.body, _KEPT_ONLY):
        uow.publish(topics.vehicle(uow.campus_id, event.vehicle_id), sequence=event.sequence)
    return EventResult(True, event.sequence + 1)


def _note_heard(uow: UnitOfWork, vehicle_id: str) -> None:
    where = uow.vehicles.whereabouts(vehicle_id)
    if where is None or uow.now - where.heard_at >= HEARD_WITHIN:
        uow.vehicles.heard(vehicle_id, uow.now)


# They change nothing that is shown of the vehicle, or what they change publishes itself.
_KEPT_ONLY = (
    DoorsChanged,
    SectionReleased,
    Blocked,
    FaultRaised,
    CodeRefused,
    HelpRequested,
    DestinationRequested,
)


def _take_effect(uow: UnitOfWork, vehicle: Vehicle, event: RecordedEvent) -> None:
    vehicle_id, body = vehicle.vehicle_id, event.body
    match body:
        case DoorsChanged():
            pass  # shown from the status; the event is kept for the record
        case VisitChanged():
            _visit_changed(uow, vehicle_id, body)
        case RiderBoarded():
            boarding.rider_boarded(uow, vehicle_id, body)
        case RiderAlighted():
            boarding.rider_alighted(uow, vehicle_id, body)
        case RiderNoShow():
            boarding.rider_no_show(uow, vehicle_id, body)
        case RiderDidNotAlight():
            boarding.rider_did_not_alight(uow, vehicle_id, body)
        case SectionReleased():
            sections.released(uow, vehicle_id, body.section_id, body.fence)
        case ModeChanged():
            conditions.mode_changed(uow, vehicle, body)
        case Blocked():
            conditions.blocked(uow, vehicle, body)
        case FaultRaised():
            conditions.fault_raised(uow, vehicle, body)
        case MapChangeFailed():
            map_changes.change_failed(uow, vehicle, body)
        case ScansReported():
            scans.scans_reported(uow, vehicle_id, body)
        case LocalizationMapStored():
            localization_changes.map_stored(uow, vehicle, body)
        case LocalizationMapFailed():
            localization_changes.change_failed(uow, vehicle, body)
        case SeatButtonPressed():
            conditions.seat_button(uow, vehicle, body)
        case CommandDone():
            conditions.command_done(uow, vehicle, body)
            recordings.command_answered(uow, event)
        case TapAnswered():
            conditions.tap_answered(uow, vehicle, body)
        case CodeRefused():
            conditions.code_refused(uow, vehicle, body)
        case HelpRequested():
            cabin_requests.help_requested(uow, vehicle, body)
        case DestinationRequested():
            pass  # answered after this transaction: `answer_destination_request`


def _visit_changed(uow: UnitOfWork, vehicle_id: str, event: VisitChanged) -> None:
    """After a completed visit the order is extended; riders who were left out are planned again."""
    visit = visits.change(uow, vehicle_id, event.visit_id, event.state)
    if event.state not in ("done", "skipped"):
        return
    if visit is None:
        _replan_after_hello(uow, vehicle_id)
        orders.retry_rejected(uow, vehicle_id)
        return
    # No-shows have been reported before: these rides were unknown to the vehicle, or it passed their stop.
    plans.requeue(uow, vehicle_id, visit.board)
    if _left_somebody(uow, vehicle_id, visit):
        plans.replan(uow, vehicle_id)
    plans.extend_order(uow, vehicle_id)
    sections.extend_grants(uow)


def _replan_after_hello(uow: UnitOfWork, vehicle_id: str) -> None:
    """A hello reported the visit before this event came: plan for the riders who were left out."""
    plan = uow.plans.get(vehicle_id)
    if plan is None:
        return
    fetched = {ride_id for visit in plan.visits for ride_id in visit.board}
    let_out = {ride_id for visit in plan.visits for ride_id in visit.alight}
    left = [r.ride_id for r in uow.rides.of_vehicle(vehicle_id, sorted(WAITING)) if r.ride_id not in fetched]
    aboard = uow.rides.of_vehicle(vehicle_id, [RideState.ABOARD])
    plans.requeue(uow, vehicle_id, left)
    if left or any(ride.ride_id not in let_out for ride in aboard):
        plans.replan(uow, vehicle_id)


def _left_somebody(uow: UnitOfWork, vehicle_id: str, visit: PlannedVisit) -> bool:
    """A rider should have boarded or alighted here and did not."""
    rides = (uow.rides.get(ride_id) for ride_id in (*visit.board, *visit.alight))
    return any(
        ride is not None
        and ride.vehicle_id == vehicle_id
        and not ride.has_ended
        and (ride.ride_id in visit.alight or ride.boarded_at is None)
        for ride in rides
    )
