"""Enrolling, placing, recalling and retiring vehicles."""

import base64
import binascii
from dataclasses import replace

from server.domain.errors import (
    EnrolmentCodeUnknown,
    EnrolmentCodeUsed,
    KeyInvalid,
    KeyUnknown,
    NoRestingPlaceFree,
    VehicleNotPlaced,
)
from server.domain.fleet.shifts import Shifts, require_sound
from server.domain.fleet.vehicles import Vehicle
from server.domain.record.identity import VehicleKey
from server.domain.record.incidents import IncidentKind
from server.usecases.fleet import departures
from server.usecases.orders import orders
from server.usecases.planning import plans
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.identity import sha256_of
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.server_events import record_event
from server.usecases.rides import lost_vehicles
from server.usecases.roads.road_positions import under_body
from server.usecases.roads.section_reservations import SectionReservations

_KEY_BYTES = 32


def enrol(uow: UnitOfWork, code: str, vehicle_id: str, public_key: str) -> Vehicle:
    """Take in a vehicle's key, once, by a code that an operator made for it.

    public_key   Ed25519, 32 bytes, base64. Enrolling a known vehicle replaces its key.
    Raises EnrolmentCodeUnknown (also: made for another vehicle, or expired), EnrolmentCodeUsed, KeyInvalid.
    """
    made = uow.identity.enrolment_code(sha256_of(code))
    if made is None or made.vehicle_id != vehicle_id or made.expires_at <= uow.now:
        raise EnrolmentCodeUnknown("the code is wrong, expired or for another vehicle; ask for a new one")
    if made.used_at is not None:
        raise EnrolmentCodeUsed("the code has been used; ask an operator for a new one")
    _require_key(public_key)
    vehicle = enrolled_vehicle(uow, vehicle_id)
    uow.identity.save_enrolment_code(replace(made, used_at=uow.now))
    uow.identity.save_vehicle_key(VehicleKey(uow.campus_id, vehicle_id, public_key, uow.now))
    record_event(uow, "vehicle.enrolled", vehicle_id, made.made_by)
    return vehicle


def key_of(uow: UnitOfWork, vehicle_id: str) -> str:
    """The public key (base64) that the vehicle's hello must be signed with. Raises KeyUnknown."""
    return _key(uow, vehicle_id).public_key


def revoke_key(uow: UnitOfWork, vehicle_id: str, by: str) -> Vehicle:
    """Revoke the key and end the open session. Raises KeyUnknown."""
    key = _key(uow, vehicle_id)
    vehicle = enrolled_vehicle(uow, vehicle_id)
    uow.identity.save_vehicle_key(replace(key, revoked_at=uow.now))
    fenced = replace(vehicle, epoch=vehicle.epoch + 1, connected=False)
    uow.vehicles.save(fenced)
    record_event(uow, "vehicle.key_revoked", vehicle_id, by)
    uow.publish(topics.vehicle_session(uow.campus_id, vehicle_id), epoch=fenced.epoch)
    return fenced


def recall(uow: UnitOfWork, vehicle_id: str, by: str) -> Vehicle:
    """Take it out of service: it takes its riders to their stops, then rests. Others get its waiting rides.

    Raises VehicleUnknown.
    """
    vehicle = replace(enrolled_vehicle(uow, vehicle_id), in_service=False)
    uow.vehicles.save(vehicle)
    record_event(uow, "vehicle.recalled", vehicle_id, by)
    _release_work(uow, vehicle_id)
    plans.replan(uow, vehicle_id)
    plans.assign_waiting(uow)
    departures.assign_planned(uow)
    return vehicle


def return_to_service(uow: UnitOfWork, vehicle_id: str, by: str) -> Vehicle:
    """It may get rides again. Raises VehicleUnknown."""
    vehicle = replace(enrolled_vehicle(uow, vehicle_id), in_service=True)
    uow.vehicles.save(vehicle)
    record_event(uow, "vehicle.returned", vehicle_id, by)
    uow.publish(topics.vehicle(uow.campus_id, vehicle_id))
    uow.publish(topics.dispatch(uow.campus_id))
    return vehicle


def set_shifts(uow: UnitOfWork, vehicle_id: str, shifts: Shifts | None, by: str) -> Vehicle:
    """When it is on duty, None for always. What it has promised already is kept.

    Raises VehicleUnknown, ShiftsInvalid.
    """
    if shifts is not None:
        require_sound(shifts)
    vehicle = replace(enrolled_vehicle(uow, vehicle_id), shifts=shifts)
    uow.vehicles.save(vehicle)
    record_event(uow, "vehicle.shifts_set", vehicle_id, by)
    uow.publish(topics.vehicle(uow.campus_id, vehicle_id))
    uow.publish(topics.dispatch(uow.campus_id))
    return vehicle


def place(uow: UnitOfWork, vehicle_id: str, lane_id: str, s_m: float, by: str) -> Vehicle:
    """Place a held vehicle by hand; it then holds the sections under its body.

    Raises VehicleUnknown, VehicleNotPlaced (no such lane), SectionsTaken.
    """
    vehicle = enrolled_vehicle(uow, vehicle_id)
    network = uow.network()
    if lane_id not in network.lanes or not 0.0 <= s_m <= network.lines[lane_id].length_m:
        raise VehicleNotPlaced(f"the map has no lane {lane_id} with a place at {s_m:.1f} m")
    record_event(uow, "vehicle.placed", vehicle_id, by)
    return stand_on(uow, vehicle, lane_id, s_m)


def stand_on(uow: UnitOfWork, vehicle: Vehicle, lane_id: str, s_m: float) -> Vehicle:
    """Enter a vehicle on the road where it stands, and give it a resting place to go to.

    Raises SectionsTaken.
    """
    SectionReservations(uow).place(vehicle.vehicle_id, under_body(uow.network(), lane_id, s_m))
    placed = replace(vehicle, placed=True)
    uow.vehicles.save(placed)
    orders.withdraw(uow, vehicle.vehicle_id)
    clear_incident(uow, IncidentKind.GROUND_CONFLICT, vehicle.vehicle_id)
    uow.publish(topics.vehicle(uow.campus_id, vehicle.vehicle_id))
    try:
        plans.choose_resting_place(uow, vehicle.vehicle_id)
    except NoRestingPlaceFree as error:
        open_incident(
            uow,
            IncidentKind.NO_RESTING_PLACE,
            vehicle.vehicle_id,
            error.detail,
            vehicle_id=vehicle.vehicle_id,
        )
    else:
        clear_incident(uow, IncidentKind.NO_RESTING_PLACE, vehicle.vehicle_id)
    return placed


def retire(uow: UnitOfWork, vehicle_id: str, by: str) -> Vehicle:
    """Take it off the roads for good: its sections become free, its waiting rides are given to others.

    Riders aboard go on with another vehicle, from the nearest stop. Raises VehicleUnknown.
    """
    vehicle = enrolled_vehicle(uow, vehicle_id)
    gone = replace(
        vehicle, retired=True, in_service=False, placed=False, connected=False, epoch=vehicle.epoch + 1
    )
    uow.vehicles.save(gone)
    _release_work(uow, vehicle_id)
    lost_vehicles.strand_riders(uow, gone, f"{vehicle_id} has been taken off the road")
    orders.withdraw(uow, vehicle_id)
    plan = uow.plans.get(vehicle_id)
    if plan is not None:
        uow.plans.save(replace(plan, version=plan.version + 1, visits=(), resting_place_id=""), plan.version)
    SectionReservations(uow).remove(vehicle_id)
    record_event(uow, "vehicle.retired", vehicle_id, by)
    uow.publish(topics.vehicle_session(uow.campus_id, vehicle_id), epoch=gone.epoch)
    plans.assign_waiting(uow)
    return gone


def _release_work(uow: UnitOfWork, vehicle_id: str) -> None:
    plans.release_waiting(uow, vehicle_id)
    plans.release_departures(uow, vehicle_id)


def _require_key(public_key: str) -> None:
    try:
        raw = base64.b64decode(public_key, validate=True)
    except (binascii.Error, ValueError) as error:
        raise KeyInvalid(f"the key is no base64: {error}") from error
    if len(raw) != _KEY_BYTES:
        raise KeyInvalid(f"an Ed25519 public key has {_KEY_BYTES} bytes, this one {len(raw)}")


def _key(uow: UnitOfWork, vehicle_id: str) -> VehicleKey:
    key = uow.identity.vehicle_key(vehicle_id)
    if key is None or key.revoked_at is not None:
        raise KeyUnknown(f"no valid key is enrolled for {vehicle_id}; enrol it with a new code")
    return key
