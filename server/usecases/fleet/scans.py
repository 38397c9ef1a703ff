"""Requests for lidar scans of an area: begun and ended by operators, answered by vehicles with parcels."""

from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import shapely

from contract.geometry import Array
from contract.localization_maps import is_same_frame
from contract.scan_parcels.parcels import ParcelHeader
from contract.wire.bounds import LONG_CHARACTERS_MAX
from contract.wire.messages import ScanArea, ScansReported, ScansRequested
from contract.wire.scans import AreaCorner
from server.domain.errors import (
    ParcelRefused,
    ScanAreaInvalid,
    ScanAreaTaken,
    ScanRequestOver,
    ScanRequestUnknown,
)
from server.domain.fleet.scans import Corner, EndReason, ScanContribution, ScanParcel, ScanRequest
from server.domain.instants import ns_of
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.server_events import THE_SERVER, record_event

# Beyond the roads' reference lines: half of a wide road.
_ROAD_M = 5.0
AREA_M2_MIN = 25.0


def request_scans(
    uow: UnitOfWork,
    name: str,
    outline: tuple[Corner, ...],
    every_m: float,
    bytes_max: int,
    hours: float,
    by: str,
) -> ScanRequest:
    """Ask all vehicles for scans of an area; no outline: of the whole campus.

    Raises CampusUnknown, ScanAreaInvalid, ScanAreaTaken.
    """
    _check_area(uow, outline)
    for other in uow.scans.open_at(uow.now):
        if not outline or not other.outline or _polygon(outline).intersects(_polygon(other.outline)):
            raise ScanAreaTaken(f"{other.name!r} is open and covers a part of this area; end it first")
    request = ScanRequest(
        campus_id=uow.campus_id,
        request_id=uow.ids.new_id("scans"),
        name=name,
        outline=outline,
        every_m=every_m,
        bytes_max=bytes_max,
        until=uow.now + timedelta(hours=hours),
        started_at=uow.now,
        started_by=by,
    )
    uow.scans.save_request(request)
    record_event(uow, "scans.requested", request.request_id, by, name)
    _tell_vehicles(uow)
    return request


def request_of(uow: UnitOfWork, request_id: str) -> ScanRequest:
    """Raises ScanRequestUnknown."""
    request = uow.scans.request(request_id)
    if request is None:
        raise ScanRequestUnknown(f"there is no request for scans {request_id}; see GET /scan-requests")
    return request


def end_request(uow: UnitOfWork, request_id: str, by: str, reason: EndReason = "operator") -> ScanRequest:
    """Vehicles keep no more scans for it, and send what they have.

    Raises ScanRequestUnknown, ScanRequestOver.
    """
    request = request_of(uow, request_id)
    if not request.is_open_at(uow.now):
        raise ScanRequestOver(f"{request.name!r} has ended already")
    ended = replace(request, ended_at=uow.now, ended_by=by, end_reason=reason)
    uow.scans.save_request(ended)
    record_event(uow, "scans.ended", request_id, by, reason)
    _tell_vehicles(uow)
    return ended


def requested_areas(uow: UnitOfWork, epoch: int) -> ScansRequested:
    """What vehicles are told: all requests that are open now, each with what may still come for it."""
    areas = tuple(
        ScanArea(
            one.request_id,
            tuple(AreaCorner(x_m, y_m) for x_m, y_m in one.outline),
            one.every_m,
            one.bytes_max,
            ns_of(one.until),
        )
        for one in uow.scans.open_at(uow.now)
    )
    return ScansRequested(epoch, areas)


def note_old_agent(uow: UnitOfWork, vehicle_id: str, areas: ScansRequested) -> None:
    """The vehicle's software cannot keep scans: said once for each request."""
    for area in areas.areas:
        known = {one.vehicle_id for one in uow.scans.contributions(area.request_id)}
        if vehicle_id not in known:
            uow.scans.save_contribution(
                ScanContribution(area.request_id, vehicle_id, "old_agent", "", 0, 0.0, 0, uow.now)
            )


def scans_reported(uow: UnitOfWork, vehicle_id: str, report: ScansReported) -> None:
    """What a vehicle says of a request; of one that is not stored here nothing is kept."""
    if uow.scans.request(report.request_id) is None:
        return
    uow.scans.save_contribution(
        ScanContribution(
            report.request_id,
            vehicle_id,
            report.state,
            report.detail[:LONG_CHARACTERS_MAX],
            report.scans,
            report.way_m,
            report.bytes_kept,
            uow.now,
        )
    )


def check_parcel(uow: UnitOfWork, vehicle_id: str, header: ParcelHeader) -> ScanRequest:
    """The request that a parcel is for. Raises ParcelRefused, CampusUnknown, VehicleUnknown."""
    enrolled_vehicle(uow, vehicle_id)
    if header.vehicle_id != vehicle_id:
        raise ParcelRefused(f"the scans were taken by {header.vehicle_id}, not by {vehicle_id}")
    if header.campus_id != uow.campus_id:
        raise ParcelRefused(f"the scans are of campus {header.campus_id}, not of {uow.campus_id}")
    if not is_same_frame(header.origin, uow.network().road_map.origin):
        raise ParcelRefused("the scans lie in another map frame than the road map in force")
    request = uow.scans.request(header.request_id)
    if request is None:
        raise ParcelRefused(f"these scans were not asked for: there is no request {header.request_id}")
    return request


def add_parcel(uow: UnitOfWork, header: ParcelHeader, sha256: str, size_bytes: int) -> bool:
    """Enter a parcel whose bytes are kept; False for one that is known. Ends a request that has enough.

    Raises ParcelRefused, CampusUnknown, VehicleUnknown.
    """
    request = check_parcel(uow, header.vehicle_id, header)
    if uow.scans.parcel(sha256) is not None:
        return False
    uow.scans.add_parcel(
        ScanParcel(
            campus_id=uow.campus_id,
            sha256=sha256,
            request_id=header.request_id,
            vehicle_id=header.vehicle_id,
            drive_id=header.drive_id,
            number=header.number,
            scans=header.scans,
            way_m=header.way_m,
            size_bytes=size_bytes,
            received_at=uow.now,
        )
    )
    received = sum(one.size_bytes for one in uow.scans.parcels(request.request_id))
    if received >= request.bytes_max and request.is_open_at(uow.now):
        end_request(uow, request.request_id, THE_SERVER, "size")
    return True


def state_at(request: ScanRequest, now: datetime) -> EndReason:
    """Why it is over, "" while it is open."""
    return request.end_reason or ("" if request.is_open_at(now) else "time")


def _check_area(uow: UnitOfWork, outline: tuple[Corner, ...]) -> None:
    network = uow.network()
    if not outline:
        return
    if len(outline) < 3:
        raise ScanAreaInvalid("an area has at least three corners; without any it is the whole campus")
    area = _polygon(outline)
    if not area.is_valid or area.area < AREA_M2_MIN:
        raise ScanAreaInvalid("the area crosses itself, or is smaller than a parking place")
    shapely.prepare(area)
    for lane in network.road_map.lanes:
        points: Array = np.array(lane.points)
        if area.distance(shapely.LineString(points)) <= _ROAD_M:
            return
    raise ScanAreaInvalid("no road of the campus leads through this area, so that no vehicle can scan it")


def _polygon(outline: tuple[Corner, ...]) -> shapely.Polygon:
    return shapely.Polygon(outline)


def _tell_vehicles(uow: UnitOfWork) -> None:
    uow.publish(topics.scans(uow.campus_id))
    for vehicle in uow.vehicles.all():
        uow.publish(topics.vehicle_outbox(uow.campus_id, vehicle.vehicle_id))
