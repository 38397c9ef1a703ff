"""Vehicles that break the protocol: they get no rides until they have kept to it for a while."""

from dataclasses import replace
from datetime import timedelta

from server.domain.fleet.vehicles import Vehicle
from server.domain.record.incidents import IncidentKind
from server.usecases.fleet.conditions import with_availability
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.server_events import record_event


def begin(uow: UnitOfWork, vehicle_id: str, detail: str) -> None:
    """The vehicle sent what is no message of the protocol. A further breach begins its time again.

    Raises VehicleUnknown.
    """
    vehicle = enrolled_vehicle(uow, vehicle_id)
    record_event(uow, "vehicle.protocol_violation", vehicle_id, vehicle_id, detail)
    _open_incident(uow, vehicle_id, f"sent an invalid message: {detail}")
    _save(uow, replace(vehicle, quarantined_at=uow.now))


def review(uow: UnitOfWork) -> None:
    """Let vehicles out of quarantine that are connected and have sent nothing invalid for `quarantine_s`.

    A vehicle whose stored record holds values that no vehicle can have was put into it when it was read.
    """
    limit = uow.now - timedelta(seconds=uow.rules.quarantine_s)
    unreadable = {where.vehicle_id: where.unreadable for where in uow.vehicles.all_whereabouts()}
    for vehicle in uow.vehicles.all():
        vehicle_id = vehicle.vehicle_id
        if unreadable.get(vehicle_id):
            _open_incident(uow, vehicle_id, f"its stored status is invalid: {unreadable[vehicle_id]}")
        if vehicle.quarantined_at is None:
            continue
        since = f"{vehicle.quarantined_at:%H:%M:%S} UTC"
        cause = f"in quarantine since {since}: a message or its stored record had invalid values"
        _open_incident(uow, vehicle_id, cause)
        if vehicle.connected and vehicle.quarantined_at <= limit and not unreadable.get(vehicle_id):
            record_event(uow, "vehicle.quarantine_lifted", vehicle_id, "")
            clear_incident(uow, IncidentKind.PROTOCOL_VIOLATION, vehicle_id)
            _save(uow, replace(vehicle, quarantined_at=None))


def _open_incident(uow: UnitOfWork, vehicle_id: str, cause: str) -> None:
    """The first cause stays in an incident that is open already."""
    open_incident(uow, IncidentKind.PROTOCOL_VIOLATION, vehicle_id, cause, vehicle_id=vehicle_id)


def _save(uow: UnitOfWork, vehicle: Vehicle) -> None:
    uow.vehicles.save(with_availability(uow, vehicle))
    uow.publish(topics.vehicle(uow.campus_id, vehicle.vehicle_id))
    uow.publish(topics.dispatch(uow.campus_id))
