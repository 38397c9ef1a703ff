"""A recorded run as scenes, in the same format as live ones."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec

from contract.roads.load import decode_map
from contract.roads.network import RoadNetwork
from contract.runlog.reader import RunLogError, open_segment, reports
from contract.wire.messages import Status
from server.domain.fleet.vehicles import Vehicle
from server.domain.orders.orders import IssuedOrder, lanes_of
from server.domain.record.runs import Run
from server.domain.rides.rides import Ride
from server.live.projection import ride_scene, vehicle_facts, with_status
from server.live.route_shape import RouteShapes
from server.live.scene import AreaScene, Scene, VehicleScene, VehicleTask

MS_NS = 1_000_000

OrderKey = tuple[str, int]


@dataclass(frozen=True, slots=True)
class Report:
    """A vehicle's status at a moment of its own clock, and the order that it followed."""

    at_ms: int
    status: Status

    @property
    def order_key(self) -> OrderKey:
        return self.status.order_id, self.status.revision


def recorded_reports(
    segments: tuple[Path, ...], from_ms: int, to_ms: int, step_ms: int, limit: int
) -> tuple[Report, ...]:
    """The reports of [from_ms, to_ms), at most one each step_ms.

    A damaged or cut segment ends where it is no longer sound.
    """
    found: list[Report] = []
    next_ms = from_ms
    for log_ns, status in _reports(segments, from_ms * MS_NS, to_ms * MS_NS):
        at_ms = log_ns // MS_NS
        if at_ms < next_ms:
            continue
        found.append(Report(at_ms, status))
        if len(found) == limit:
            break
        next_ms = at_ms + step_ms
    return tuple(found)


def recorded_network(segments: tuple[Path, ...]) -> RoadNetwork:
    """The map that the run was driven on, as its first segment holds it. Raises RunLogError, MapError."""
    return RoadNetwork(decode_map(open_segment(segments[0]).road_map))


def recorded_scenes(
    run: Run,
    vehicle: Vehicle,
    found: tuple[Report, ...],
    rides: Mapping[str, Ride],
    orders: Mapping[OrderKey, IssuedOrder],
    network: RoadNetwork | None,
) -> tuple[Scene, ...]:
    """One scene for each report.

    rides    those that may have been aboard, by id
    orders   those that the reports name
    network  the run's map; without it no route is drawn
    """
    facts = msgspec.structs.replace(
        vehicle_facts(vehicle), connected=True, held=False, in_service=True, charging=False
    )
    blank = VehicleScene(vehicle.vehicle_id, facts)
    scenes: list[Scene] = []
    shapes = None if network is None else RouteShapes(network.lines)
    task, task_key = VehicleTask(), None
    for report in found:
        key = (report.order_key, report.status.visit_id)
        if key != task_key:
            order = orders.get(report.order_key)
            task, task_key = _task(order, shapes, report.status), key
        scenes.append(_scene(run, report, msgspec.structs.replace(blank, task=task), rides))
    return tuple(scenes)


def _reports(segments: tuple[Path, ...], from_ns: int, to_ns: int) -> Iterator[tuple[int, Status]]:
    for path in segments:
        try:
            yield from reports(path, from_ns, to_ns)
        except RunLogError as error:
            if error.code not in ("truncated", "damaged"):
                raise


def _task(order: IssuedOrder | None, shapes: RouteShapes | None, status: Status) -> VehicleTask:
    """The rest of the vehicle's order at this report."""
    visits = () if order is None else order.payload.visits
    present = next((k for k, visit in enumerate(visits) if visit.visit_id == status.visit_id), None)
    if present is None:
        return VehicleTask()
    next_stop = next((visit.stop_id for visit in visits[present:] if visit.stop_id), "")
    if shapes is None:
        return VehicleTask(next_stop)
    route = shapes.ahead(lanes_of(visits[present:]), visits[-1].s_m, status.lane_id, status.s_m)
    return VehicleTask(next_stop, route=route)


def _scene(run: Run, report: Report, vehicle: VehicleScene, rides: Mapping[str, Ride]) -> Scene:
    aboard = [rides[ride_id] for ride_id in report.status.aboard if ride_id in rides]
    task = msgspec.structs.replace(vehicle.task, people_aboard=sum(ride.party for ride in aboard))
    vehicle = msgspec.structs.replace(vehicle, task=task)
    return Scene(
        at_ms=report.at_ms,
        campus_id=run.campus_id,
        map_version=run.map_version,
        vehicles=(with_status(vehicle, report.status, report.at_ms),),
        rides=tuple(ride_scene(ride, state="aboard") for ride in aboard),
        areas=_areas(report),
    )


def _areas(report: Report) -> tuple[AreaScene, ...]:
    """The cameras' reports that the vehicle had received."""
    driving = report.status.driving
    if driving is None:
        return ()
    return tuple(
        AreaScene(area.area_id, area.camera_count, report.at_ms - round(1000 * area.camera_age_s))
        for area in driving.areas
        if area.camera_count >= 0
    )
