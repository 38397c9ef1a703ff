"""A vehicle's condition: mode, obstacles, faults, and its answers to commands and taps."""

from dataclasses import replace

from contract.wire.messages import (
    Blocked,
    CodeRefused,
    CommandDone,
    DriveMode,
    FaultRaised,
    ModeChanged,
    SeatButtonPressed,
    TapAnswered,
)
from contract.wire.reasons import FaultCode
from server.domain.fleet.vehicles import Vehicle
from server.domain.record.incidents import IncidentKind
from server.usecases.orders import sections
from server.usecases.planning import plans
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import travel_time_factors
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.server_events import record_event

_INCIDENT_OF_MODE: dict[DriveMode, IncidentKind] = {
    "manual": IncidentKind.TAKEOVER,
    "minimal_risk": IncidentKind.MINIMAL_RISK_STOP,
    "fault": IncidentKind.VEHICLE_FAULT,
}
# Warnings that do not go away by themselves: the vehicle drives on with less than it has.
_FOR_A_TECHNICIAN: frozenset[FaultCode] = frozenset({"lidar_silent", "lidar_unusable", "lidar_moved"})
# Characters of the devices' names: an incident's subject has 200 in all.
_DEVICES_MAX = 80


def mode_changed(uow: UnitOfWork, vehicle: Vehicle, event: ModeChanged) -> None:
    """A vehicle that does not drive by itself gets no new rides; one that does again gets its road."""
    vehicle_id = vehicle.vehicle_id
    after = with_mode(uow, vehicle, event.mode)
    uow.vehicles.save(after)
    cause = ", ".join(event.faults) or event.detail or event.reason or ""
    record_event(uow, f"vehicle.{event.mode}", vehicle_id, vehicle_id, cause)
    uow.publish(topics.vehicle(uow.campus_id, vehicle_id), mode=event.mode)
    if event.mode != "autonomous":
        travel_time_factors.interrupted(uow, vehicle_id)
    kind = _INCIDENT_OF_MODE.get(event.mode)
    if kind is not None:
        open_incident(uow, kind, vehicle_id, cause or event.mode, vehicle_id=vehicle_id)
    if event.mode == "autonomous":
        for cleared in _INCIDENT_OF_MODE.values():
            clear_incident(uow, cleared, vehicle_id)
        sections.extend_grants(uow)


def with_mode(uow: UnitOfWork, vehicle: Vehicle, mode: DriveMode) -> Vehicle:
    """The vehicle in another mode, with since when it has been unavailable.

    A timed hold ends only while the vehicle is held: after a takeover or a fault an operator resumes it.
    """
    ends = vehicle.hold_ends if mode == "held" else None
    return with_availability(uow, replace(vehicle, mode=mode, held=mode != "autonomous", hold_ends=ends))


def with_availability(uow: UnitOfWork, vehicle: Vehicle) -> Vehicle:
    """The vehicle with since when it has not been available."""
    if vehicle.is_available:
        return replace(vehicle, unavailable_since=None)
    return replace(vehicle, unavailable_since=vehicle.unavailable_since or uow.now)


def blocked(uow: UnitOfWork, vehicle: Vehicle, event: Blocked) -> None:
    vehicle_id = vehicle.vehicle_id
    if event.cleared:
        clear_incident(uow, IncidentKind.VEHICLE_BLOCKED, vehicle_id)
        return
    cause = f"stands before something {event.obstacle_m:.1f} m ahead"
    open_incident(uow, IncidentKind.VEHICLE_BLOCKED, vehicle_id, cause, vehicle_id=vehicle_id)


def fault_raised(uow: UnitOfWork, vehicle: Vehicle, event: FaultRaised) -> None:
    """A fault that stops the vehicle is an incident, and so is a lidar that needs a technician.

    Lesser ones are noted.
    """
    fault, vehicle_id = event.fault, vehicle.vehicle_id
    devices = fault.detail[:_DEVICES_MAX]
    cause = f"{fault.code} ({devices})" if devices else fault.code
    record_event(
        uow,
        "vehicle.fault_cleared" if event.cleared else "vehicle.fault_raised",
        vehicle_id,
        vehicle_id,
        cause,
    )
    subject = f"{vehicle_id}/{fault.code}" + (f"/{devices}" if devices else "")
    if event.cleared:
        clear_incident(uow, IncidentKind.VEHICLE_FAULT, subject)
    elif fault.severity == "stop" or fault.code in _FOR_A_TECHNICIAN:
        open_incident(uow, IncidentKind.VEHICLE_FAULT, subject, cause, vehicle_id=vehicle_id)


def seat_button(uow: UnitOfWork, vehicle: Vehicle, event: SeatButtonPressed) -> None:
    """The vehicle stops by itself, and expected times are updated. Only a refusal is an incident."""
    vehicle_id = vehicle.vehicle_id
    place = f"lane {event.lane_id} at {event.s_m:.0f} m"
    record_event(
        uow, "vehicle.seat_button", vehicle_id, vehicle_id, place if event.accepted else event.reason
    )
    uow.publish(topics.vehicle(uow.campus_id, vehicle_id), seat=event.seat)
    if event.accepted:
        plans.refresh_expected(uow)
        return
    cause = f"seat {event.seat} wants to get off: {event.reason}"
    open_incident(uow, IncidentKind.SEAT_BUTTON, vehicle_id, cause, vehicle_id=vehicle_id)


def command_done(uow: UnitOfWork, vehicle: Vehicle, event: CommandDone) -> None:
    command = uow.vehicles.command(event.command_id)
    if command is None or command.vehicle_id != vehicle.vehicle_id or command.state != "pending":
        return
    answered = replace(command, state="done" if event.done else "failed", detail=event.detail)
    uow.vehicles.save_command(answered)
    if (command.kind, event.done) in (("hold", False), ("resume", True)):
        # The server counts a hold from the command; the vehicle's answer overrides that.
        uow.vehicles.save(with_mode(uow, replace(vehicle, hold_ends=None), vehicle.mode))
    uow.publish(topics.vehicle(uow.campus_id, vehicle.vehicle_id), command_id=command.command_id)


def tap_answered(uow: UnitOfWork, vehicle: Vehicle, event: TapAnswered) -> None:
    tap = uow.rides.tap(event.tap_id)
    if tap is None or tap.vehicle_id != vehicle.vehicle_id or tap.state != "pending":
        return
    answered = replace(tap, state="accepted" if event.accepted else "refused", reason=event.reason)
    uow.rides.save_tap(answered)
    uow.publish(topics.ride(uow.campus_id, tap.ride_id), tap_id=tap.tap_id, tap=answered.state)


def code_refused(uow: UnitOfWork, vehicle: Vehicle, event: CodeRefused) -> None:
    record_event(uow, "vehicle.code_refused", vehicle.vehicle_id, vehicle.vehicle_id, event.visit_id)
