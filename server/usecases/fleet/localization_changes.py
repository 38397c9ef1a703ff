"""How vehicles learn of the localization map in force, and what they say of it. None of it stops one."""

from dataclasses import replace

from contract.localization_maps import is_same_frame
from contract.wire.bounds import LONG_CHARACTERS_MAX
from contract.wire.localization_maps import LocalizationMapPublished
from contract.wire.messages import LocalizationMapFailed, LocalizationMapStored
from server.domain.fleet.vehicles import Vehicle
from server.domain.record.incidents import IncidentKind
from server.domain.roads.localization_maps import LocalizationMap
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.server_events import record_event

STORED = "stored"


def announcement(uow: UnitOfWork, vehicle_id: str, announced: str) -> LocalizationMapPublished | None:
    """The localization map in force, for a vehicle that localizes by another one; None if nothing is to say.

    announced  the version that this session has told the vehicle last, "" for none: the vehicle may be on its
               way to that one. Raises VehicleUnknown.
    """
    vehicle = enrolled_vehicle(uow, vehicle_id)
    wanted = _wanted(uow, vehicle)
    if wanted is None:
        return None
    version = wanted.map_version
    if vehicle.localization_map == version and announced in ("", version):
        return None
    if vehicle.localization_change == STORED and announced == version:
        return None  # it changes over when it stands, which may be hours away
    return LocalizationMapPublished(
        vehicle.epoch, wanted.kind, version, wanted.manifest_sha256, wanted.manifest_bytes
    )


def with_localization_map(uow: UnitOfWork, vehicle: Vehicle) -> Vehicle:
    """The vehicle after its hello: if it localizes by the map in force, its failure is over."""
    wanted = _wanted(uow, vehicle)
    if wanted is not None and vehicle.localization_map != wanted.map_version:
        return vehicle
    if vehicle.localization_change:
        clear_incident(uow, IncidentKind.LOCALIZATION_MAP_NOT_CHANGED, vehicle.vehicle_id)
    return replace(vehicle, localization_change="")


def map_stored(uow: UnitOfWork, vehicle: Vehicle, event: LocalizationMapStored) -> None:
    """The vehicle has every tile of it, and waits until it stands."""
    if _is_awaited(uow, vehicle, event.map_version):
        clear_incident(uow, IncidentKind.LOCALIZATION_MAP_NOT_CHANGED, vehicle.vehicle_id)
        _save_change(uow, vehicle, STORED)


def change_failed(uow: UnitOfWork, vehicle: Vehicle, event: LocalizationMapFailed) -> None:
    """The vehicle drives on with the localization map that it has; operators learn why."""
    vehicle_id, cause = vehicle.vehicle_id, f"{event.code}: {event.detail}"[:LONG_CHARACTERS_MAX]
    record_event(
        uow, "vehicle.localization_map_failed", vehicle_id, vehicle_id, f"{event.map_version} {cause}"
    )
    if _is_awaited(uow, vehicle, event.map_version):
        kind = IncidentKind.LOCALIZATION_MAP_NOT_CHANGED
        open_incident(uow, kind, vehicle_id, cause, vehicle_id=vehicle_id)
        _save_change(uow, vehicle, event.code)


def _save_change(uow: UnitOfWork, vehicle: Vehicle, change: str) -> None:
    uow.vehicles.save(replace(vehicle, localization_change=change))
    uow.publish(topics.vehicle(uow.campus_id, vehicle.vehicle_id))


def _is_awaited(uow: UnitOfWork, vehicle: Vehicle, map_version: str) -> bool:
    """Not so if another one has been put in force since, or the vehicle has changed over."""
    wanted = _wanted(uow, vehicle)
    return wanted is not None and wanted.map_version == map_version != vehicle.localization_map


def _wanted(uow: UnitOfWork, vehicle: Vehicle) -> LocalizationMap | None:
    """The map in force of the vehicle's kind, if it lies in the frame of the road map in force."""
    if not vehicle.localizes_by:
        return None
    in_force = uow.localization_maps.in_force().get(vehicle.localizes_by)
    if in_force is None or uow.maps.active_version() is None:
        return None
    return in_force if is_same_frame(in_force.origin, uow.network().road_map.origin) else None
