"""Recorded runs as vehicles upload them, segment by segment."""

from collections.abc import Mapping

from server.domain.errors import SegmentConflict, SegmentUnknown
from server.domain.fleet.vehicles import Vehicle
from server.domain.instants import ns_of
from server.domain.record.events import RecordedEvent
from server.domain.record.recordings import VehicleMoment
from server.domain.record.runs import Run, Segment
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import recordings
from server.usecases.record.enrolled_vehicles import enrolled_vehicle


def add_segment(
    uow: UnitOfWork, segment: Segment, recording_ends: Mapping[str, VehicleMoment] | None = None
) -> bool:
    """Enter a segment whose bytes are stored already; False for a repeat.

    recording_ends  commands to recordings that are marked in it, and when

    Raises VehicleUnknown, SegmentConflict.
    """
    vehicle = enrolled_vehicle(uow, segment.vehicle_id)
    known = uow.runs.segment(segment.sha256)
    if known is not None:
        return _same_place(known, segment)
    run = uow.runs.get(segment.vehicle_id, segment.boot_id)
    if run is None:
        uow.runs.add(_run(uow, vehicle, segment.boot_id))
    elif any(other.number == segment.number for other in run.segments):
        raise SegmentConflict(
            f"segment {segment.number} of this run of {segment.vehicle_id} is stored with other content"
        )
    uow.runs.add_segment(segment)
    recordings.note_file(uow, segment.vehicle_id, recording_ends or {})
    uow.publish(topics.runs(uow.campus_id), vehicle_id=segment.vehicle_id, boot_id=segment.boot_id)
    return True


def segment_of(uow: UnitOfWork, sha256: str) -> Segment:
    """Raises SegmentUnknown."""
    segment = uow.runs.segment(sha256)
    if segment is None:
        raise SegmentUnknown(f"no segment {sha256} is stored")
    return segment


def begin_run(uow: UnitOfWork, vehicle: Vehicle, boot_id: str) -> None:
    """Enter the run that the vehicle records now, once."""
    if uow.runs.get(vehicle.vehicle_id, boot_id) is None:
        uow.runs.add(_run(uow, vehicle, boot_id))
        uow.publish(topics.runs(uow.campus_id), vehicle_id=vehicle.vehicle_id, boot_id=boot_id)


def segment_with(uow: UnitOfWork, event: RecordedEvent) -> Segment | None:
    """The segment that has the moment of a vehicle's event; None while it has not come.

    An agent may number its events under another boot than it records. Its clock is one, and begins anew when
    the computer starts: of several segments with that moment it is the one that came next to the event.
    """
    found = uow.runs.segments_at(event.vehicle_id, event.stamp_ns)
    return min(found, key=lambda one: abs(ns_of(one.received_at) - event.received_ns), default=None)


def _same_place(known: Segment, segment: Segment) -> bool:
    place = (segment.vehicle_id, segment.boot_id, segment.number)
    if (known.vehicle_id, known.boot_id, known.number) != place:
        raise SegmentConflict(f"the same content is stored as segment {known.number} of another run")
    return False


def _run(uow: UnitOfWork, vehicle: Vehicle, boot_id: str) -> Run:
    return Run(
        campus_id=uow.campus_id,
        vehicle_id=vehicle.vehicle_id,
        boot_id=boot_id,
        started_at=uow.now,
        software=vehicle.software,
        stack=vehicle.stack,
        map_version=vehicle.map_version,
    )
