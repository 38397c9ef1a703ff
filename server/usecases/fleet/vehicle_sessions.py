"""Sessions, positions and silence of vehicles, as the server records them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import timedelta

import msgspec

from contract.roads.network import AT_SEA_M, RoadNetwork
from contract.wire.localization_maps import LocalizesBy
from contract.wire.messages import EventLogState, OrderProgress, Status
from server.domain.errors import CampusUnknown, SectionsTaken, SessionFenced
from server.domain.fleet.vehicles import STANDS_MPS, StatusReport, Vehicle, VehicleSession
from server.domain.orders.orders import OrderState
from server.domain.record.incidents import IncidentKind
from server.usecases.fleet import announcements
from server.usecases.fleet.conditions import with_availability, with_mode
from server.usecases.fleet.localization_changes import with_localization_map
from server.usecases.fleet.map_changes import with_reported_map
from server.usecases.fleet.vehicles import stand_on
from server.usecases.orders import orders, visits
from server.usecases.planning import plans
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.commands import send_command
from server.usecases.record.enrolled_vehicles import active_vehicle
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.runs import begin_run
from server.usecases.record.server_events import record_event
from server.usecases.roads.section_reservations import SectionReservations

# More grants than a campus gives between two backups.
FENCES_SKIPPED = 10_000_000


@dataclass(frozen=True, slots=True)
class HelloFacts:
    """The content of a verified hello. run_boot_id: under which the vehicle records, "" for boot_id."""

    vehicle_id: str
    boot_id: str
    software: str
    stack: str
    map_version: str
    logs: tuple[EventLogState, ...]
    progress: OrderProgress | None
    seats: int
    wheelchair_places: int
    run_boot_id: str = ""
    localizes_by: LocalizesBy = ""
    localization_map: str = ""


def open_session(uow: UnitOfWork, hello: HelloFacts) -> VehicleSession:
    """Open a session with a new epoch; older ones are fenced. The vehicle's visit states are taken over.

    The hub applies the boot's unacknowledged events next and sends the outbox after them.
    Raises VehicleUnknown.
    """
    vehicle = active_vehicle(uow, hello.vehicle_id)
    opened = replace(
        vehicle,
        epoch=vehicle.epoch + 1,
        boot_id=hello.boot_id,
        connected=True,
        software=hello.software,
        stack=hello.stack,
        map_version=hello.map_version,
        seats=hello.seats,
        wheelchair_places=hello.wheelchair_places,
        localizes_by=hello.localizes_by,
        localization_map=hello.localization_map,
    )
    has_started = hello.boot_id != vehicle.boot_id and not _drives_on(uow, hello)
    forgotten = _skip_forgotten(uow, hello)
    if forgotten:
        # Where it is, and what it holds, is not known either: its next position places it.
        uow.sections.skip_fences(FENCES_SKIPPED)
        if vehicle.placed:
            SectionReservations(uow).remove(hello.vehicle_id)
        opened = replace(opened, placed=False)
    if has_started or forgotten:
        # After a start a vehicle stands and is held, whatever it was before. What it was in forgotten events
        # is not known, and it may be driving: it is in no use until an operator has seen to it.
        opened = with_mode(uow, replace(opened, hold_ends=None), "held")
    opened = with_availability(uow, with_localization_map(uow, with_reported_map(uow, opened)))
    uow.vehicles.save(opened)
    uow.vehicles.heard(hello.vehicle_id, uow.now)
    if has_started:
        announcements.say_again(uow, hello.vehicle_id)
    begin_run(uow, opened, hello.run_boot_id or hello.boot_id)
    clear_incident(uow, IncidentKind.VEHICLE_SILENT, hello.vehicle_id)
    _reconcile(uow, hello)
    if forgotten:
        # It drives on ground that this database may give to others: it stands, and is placed there.
        send_command(uow, hello.vehicle_id, "hold", "server", "the server was restored from a backup")
        # The pickup may be over: whether the party has been aboard, the next one tells.
        plans.release_waiting(uow, hello.vehicle_id)
    uow.publish(topics.vehicle_session(uow.campus_id, hello.vehicle_id), epoch=opened.epoch)
    uow.publish(topics.vehicle(uow.campus_id, hello.vehicle_id), epoch=opened.epoch)
    boots = dict.fromkeys((hello.boot_id, *(log.boot_id for log in hello.logs)))
    acknowledged = tuple((boot_id, uow.events.count(hello.vehicle_id, boot_id)) for boot_id in boots)
    return VehicleSession(hello.vehicle_id, opened.epoch, acknowledged)


def _skip_forgotten(uow: UnitOfWork, hello: HelloFacts) -> bool:
    """Go on behind events that this database does not have, and the vehicle neither. Are there any?

    A vehicle forgets an event only once it is stored: this database is an older one, from a backup.
    """
    forgotten = False
    for kept in hello.logs:
        stored = uow.events.count(hello.vehicle_id, kept.boot_id)
        if kept.first_unacknowledged > stored:
            forgotten = True
            uow.events.skip_to(hello.vehicle_id, kept.boot_id, kept.first_unacknowledged)
            lost = f"events {stored} to {kept.first_unacknowledged - 1} of {kept.boot_id}"
            record_event(uow, "vehicle.events_lost", hello.vehicle_id, hello.vehicle_id, lost)
    return forgotten


def _drives_on(uow: UnitOfWork, hello: HelloFacts) -> bool:
    """Only the process that talks to the server has started: the one that drives records a known run.

    It says nothing of a mode that has not changed, so the server keeps what it knows.
    """
    run_boot_id = hello.run_boot_id or hello.boot_id
    return uow.runs.get(hello.vehicle_id, run_boot_id) is not None


def close_session(uow: UnitOfWork, vehicle_id: str, epoch: int) -> None:
    """The link is gone. The end of an older epoch changes nothing."""
    vehicle = uow.vehicles.get(vehicle_id)
    if vehicle is None or vehicle.epoch != epoch or not vehicle.connected:
        return
    uow.vehicles.save(with_availability(uow, replace(vehicle, connected=False)))
    uow.publish(topics.vehicle(uow.campus_id, vehicle_id), connected=0)


def require_epoch(uow: UnitOfWork, vehicle_id: str, epoch: int) -> None:
    """Raises SessionFenced when a newer session has taken over."""
    vehicle = uow.vehicles.get(vehicle_id)
    if vehicle is None or vehicle.epoch != epoch:
        raise SessionFenced(f"a newer session of {vehicle_id} has taken over from epoch {epoch}")


def key_conflict(uow: UnitOfWork, vehicle_id: str, boot_id: str) -> str:
    """Why a hello with the right key is refused: two agents use that key. "" if one does.

    Another boot was heard a moment ago: it still runs. Which of the two is the vehicle cannot be known, so
    neither is served until an operator closes the incident. Raises VehicleUnknown.
    """
    vehicle = active_vehicle(uow, vehicle_id)
    if uow.incidents.open_about(IncidentKind.KEY_CONFLICT, vehicle_id) is not None:
        return f"the incident of two agents with the key of {vehicle_id} is open; an operator closes it"
    where = uow.vehicles.whereabouts(vehicle_id)
    within = timedelta(seconds=uow.rules.key_conflict_within_s)
    # Heard in the future: the clock has been set back since, which says nothing about the vehicle.
    is_alive = vehicle.connected and where is not None and abs(uow.now - where.heard_at) < within
    if not is_alive or boot_id == vehicle.boot_id:
        return ""
    detail = f"boot {boot_id} said hello while boot {vehicle.boot_id} was still heard"
    open_incident(uow, IncidentKind.KEY_CONFLICT, vehicle_id, detail, vehicle_id=vehicle_id)
    fenced = replace(vehicle, epoch=vehicle.epoch + 1, connected=False)
    uow.vehicles.save(with_availability(uow, fenced))
    uow.publish(topics.vehicle_session(uow.campus_id, vehicle_id), epoch=fenced.epoch, key_conflict=1)
    uow.publish(topics.vehicle(uow.campus_id, vehicle_id), connected=0)
    return detail


def record_status(uow: UnitOfWork, reports: Sequence[StatusReport]) -> None:
    """Store a batch of positions. The first one of a standing vehicle on a lane places it on the road.

    The driving view goes to the screens and is not stored: the run log has it.
    """
    vehicles = {vehicle.vehicle_id: vehicle for vehicle in uow.vehicles.all()}
    known = [_without_driving_view(report) for report in reports if report.vehicle_id in vehicles]
    uow.vehicles.save_status(known)
    newest = {report.vehicle_id: report for report in known}
    for vehicle_id, report in sorted(newest.items()):
        _check_position(uow, vehicles[vehicle_id], report.status)


def _without_driving_view(report: StatusReport) -> StatusReport:
    if report.status.driving is None:
        return report
    return replace(report, status=msgspec.structs.replace(report.status, driving=None))


def note_silence(uow: UnitOfWork) -> tuple[str, ...]:
    """Open or close the incident of each silent vehicle. Returns the silent vehicles."""
    silent_after = timedelta(seconds=uow.rules.silent_after_s)
    heard_at = {where.vehicle_id: where.heard_at for where in uow.vehicles.all_whereabouts()}
    silent = []
    for vehicle in uow.vehicles.all():
        last = heard_at.get(vehicle.vehicle_id)
        if last is None or not vehicle.boot_id:
            continue
        if uow.incidents.open_about(IncidentKind.KEY_CONFLICT, vehicle.vehicle_id) is not None:
            continue  # neither agent is listened to
        if abs(uow.now - last) > silent_after:  # also after the clock was set back
            silent.append(vehicle.vehicle_id)
            cause = f"not heard since {last:%H:%M:%S} UTC"
            open_incident(
                uow,
                IncidentKind.VEHICLE_SILENT,
                vehicle.vehicle_id,
                cause,
                vehicle_id=vehicle.vehicle_id,
            )
        else:
            clear_incident(uow, IncidentKind.VEHICLE_SILENT, vehicle.vehicle_id)
    return tuple(silent)


def _reconcile(uow: UnitOfWork, hello: HelloFacts) -> None:
    """Reconcile order and report: the vehicle decides what has happened, the server what shall happen."""
    order = uow.orders.current(hello.vehicle_id)
    held = hello.progress
    if held is not None:
        visits.take_over(uow, hello.vehicle_id, held.visits)
        order = uow.orders.current(hello.vehicle_id)
    if order is None or order.state is OrderState.DONE:
        return
    follows = held is not None and (held.order_id, held.revision) == (order.order_id, order.revision)
    if follows and order.state is not OrderState.ACCEPTED:
        orders.accepted(uow, hello.vehicle_id, order.order_id, order.revision)
    elif not follows and order.state is OrderState.ACCEPTED:
        record_event(uow, "order.lost", hello.vehicle_id, hello.vehicle_id)
        orders.repeat(uow, hello.vehicle_id)


def _check_position(uow: UnitOfWork, vehicle: Vehicle, status: Status) -> None:
    vehicle_id = vehicle.vehicle_id
    try:
        network = uow.network()
    except CampusUnknown:
        return
    if _is_off_the_roads(network, status):
        pose = status.pose_map
        open_incident(
            uow,
            IncidentKind.IMPOSSIBLE_POSITION,
            vehicle_id,
            f"says it is at ({pose.x_m:.0f}, {pose.y_m:.0f}) m, on no road of the map; check its positioning",
            vehicle_id=vehicle_id,
        )
        return
    clear_incident(uow, IncidentKind.IMPOSSIBLE_POSITION, vehicle_id)
    # One that drives by another map would refuse every order: it gets none until it has this map. One that
    # drives has left the sections under it before it knows that it holds them.
    stands = abs(status.speed_mps) <= STANDS_MPS
    if not vehicle.placed and stands and vehicle.map_version in ("", network.map_version):
        _place_by(uow, vehicle, network, status)


def _is_off_the_roads(network: RoadNetwork, status: Status) -> bool:
    pose = status.pose_map
    if _is_where_it_says(network, status):
        return False
    return all(network.locate(pose.x_m, pose.y_m, pose.yaw_rad + turned) is None for turned in (0.0, math.pi))


def _is_where_it_says(network: RoadNetwork, status: Status) -> bool:
    """Its position is near the place on the lane that it names: then no lane need be searched for."""
    line = network.lines.get(status.lane_id)
    if line is None:
        return False
    k = min(int(line.s.searchsorted(status.s_m)), len(line.s) - 1)
    x_m, y_m = line.points[k].tolist()
    return math.hypot(status.pose_map.x_m - x_m, status.pose_map.y_m - y_m) <= AT_SEA_M


def _place_by(uow: UnitOfWork, vehicle: Vehicle, network: RoadNetwork, status: Status) -> None:
    pose = status.pose_map
    found = network.locate(pose.x_m, pose.y_m, pose.yaw_rad)
    if status.lane_id in network.lanes:
        lane_id, s_m = status.lane_id, status.s_m
    elif found is not None:
        lane_id, s_m, _ = found
    else:
        return
    try:
        stand_on(uow, vehicle, lane_id, s_m)
    except SectionsTaken as error:
        vehicle_id = vehicle.vehicle_id
        open_incident(uow, IncidentKind.GROUND_CONFLICT, vehicle_id, error.detail, vehicle_id=vehicle_id)
