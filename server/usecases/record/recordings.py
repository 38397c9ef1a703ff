"""Marks in what a vehicle records, and named recordings that operators start and stop.

A vehicle records always. A mark names a moment of that; a recording names a span of it, which begins and ends
with a file of its own. A vehicle that is out of reach hears of either when it is back: until then the server
has them, and says that the vehicle does not.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import timedelta

from contract.wire.messages import LATER_KINDS, CommandDone
from server.domain.errors import RecordingOver, RecordingUnderWay, RecordingUnknown
from server.domain.fleet.vehicles import VehicleCommand
from server.domain.record.events import RecordedEvent
from server.domain.record.recordings import (
    RECORDING_COMMANDS,
    Recording,
    VehicleMoment,
    answered,
    found_in_file,
)
from server.domain.record.runs import Segment
from server.domain.service.announcements import AnnouncementState
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.commands import send_command
from server.usecases.record.enrolled_vehicles import enrolled_vehicle

# A scene or a picture is asked for by an operator who looks now.
SCENE_WITHIN = timedelta(seconds=10)
TOO_OLD = "the vehicle's agent is too old for this command: update it"
ANNOUNCEMENT_OVER = "the announcement was over before the vehicle was in reach"
TOO_LATE = "the vehicle was not in reach in time: ask again"


def mark(uow: UnitOfWork, vehicle_id: str, note: str, by: str) -> VehicleCommand:
    """Mark the present moment of a vehicle's recording. Raises VehicleUnknown."""
    return send_command(uow, vehicle_id, "mark", by, note)


def start(uow: UnitOfWork, vehicle_id: str, name: str, by: str) -> Recording:
    """Raises VehicleUnknown, RecordingUnderWay."""
    enrolled_vehicle(uow, vehicle_id)
    newest = uow.recordings.newest_of(vehicle_id)
    if newest is not None and newest.is_open:
        raise RecordingUnderWay(f"{newest.name!r} of {vehicle_id} has not been stopped: stop it first")
    command = send_command(uow, vehicle_id, "start_recording", by, name)
    recording = Recording(uow.campus_id, command.command_id, vehicle_id, name, uow.now, by)
    uow.recordings.save(recording)
    return recording


def stop(uow: UnitOfWork, vehicle_id: str, recording_id: str, by: str) -> Recording:
    """Raises RecordingUnknown, RecordingOver."""
    recording = uow.recordings.get(recording_id)
    if recording is None or recording.vehicle_id != vehicle_id:
        raise RecordingUnknown(f"{vehicle_id} has no recording {recording_id}; see GET /recordings")
    if not recording.is_open:
        raise RecordingOver(f"{recording.name!r} of {vehicle_id} is over: it is {recording.state}")
    command = send_command(uow, vehicle_id, "stop_recording", by, recording.name)
    stopped = replace(
        recording, state="stopping", stop_id=command.command_id, stopped_at=uow.now, stopped_by=by
    )
    uow.recordings.save(stopped)
    return stopped


def command_answered(uow: UnitOfWork, event: RecordedEvent) -> None:
    """The vehicle has answered a command: if it starts or stops a recording, that is so now."""
    body = event.body
    if isinstance(body, CommandDone):
        moment = VehicleMoment(event.boot_id, event.stamp_ns) if body.done else None
        _answered(uow, event.vehicle_id, body.command_id, moment, body.detail)


def deliverable(
    uow: UnitOfWork, commands: Sequence[VehicleCommand], understands: Sequence[str]
) -> tuple[VehicleCommand, ...]:
    """The commands that can be sent; the others have failed, each with the reason.

    understands  the kinds of `LATER_KINDS` that the vehicle's agent can read: one that it cannot would end
                 its session, and be sent again in the next one
    """
    sent = []
    for command in commands:
        reason = ""
        if command.kind in LATER_KINDS and command.kind not in understands:
            reason = TOO_OLD
        elif command.kind in ("show_scene", "show_camera") and uow.now - command.made_at > SCENE_WITHIN:
            reason = TOO_LATE
        elif command.announcement_id and _is_announcement_over(uow, command.announcement_id):
            reason = ANNOUNCEMENT_OVER
        if not reason:
            sent.append(command)
            continue
        uow.vehicles.save_command(replace(command, state="failed", detail=reason))
        _answered(uow, command.vehicle_id, command.command_id, None, reason)
        uow.publish(topics.vehicle(uow.campus_id, command.vehicle_id), command_id=command.command_id)
    return tuple(sent)


def _is_announcement_over(uow: UnitOfWork, announcement_id: str) -> bool:
    announcement = uow.announcements.get(announcement_id)
    return announcement is None or announcement.state_at(uow.now) is AnnouncementState.OVER


def note_file(uow: UnitOfWork, vehicle_id: str, ends: Mapping[str, VehicleMoment]) -> None:
    """A file has come. ends: the commands to recordings that are marked in it, and when."""
    for command_id, moment in ends.items():
        recording = uow.recordings.of_command(command_id)
        if recording is not None and recording.vehicle_id == vehicle_id:
            uow.recordings.save(found_in_file(recording, command_id, moment))


def files_of(uow: UnitOfWork, recording: Recording) -> tuple[Segment, ...]:
    """The segments of a recording that have been uploaded, in order."""
    begun, ended = recording.begun, recording.ended
    if begun is None:
        return ()
    boots = dict.fromkeys([begun.boot_id, *([ended.boot_id] if ended is not None else [])])
    found: list[Segment] = []
    for boot_id in boots:
        run = uow.runs.get(recording.vehicle_id, boot_id)
        found += [] if run is None else [one for one in run.segments if _is_of(one, begun, ended)]
    return tuple(found)


def is_kept(recording: Recording, files: Sequence[Segment]) -> bool:
    """All of it has been uploaded."""
    ended = recording.ended
    return ended is not None and any(
        one.boot_id == ended.boot_id and one.first_ns <= ended.stamp_ns <= one.last_ns for one in files
    )


def _is_of(segment: Segment, begun: VehicleMoment, ended: VehicleMoment | None) -> bool:
    if segment.boot_id == begun.boot_id and segment.last_ns < begun.stamp_ns:
        return False
    return not (ended is not None and segment.boot_id == ended.boot_id and segment.first_ns > ended.stamp_ns)


def _answered(
    uow: UnitOfWork, vehicle_id: str, command_id: str, moment: VehicleMoment | None, detail: str
) -> None:
    command = uow.vehicles.command(command_id)
    if command is None or command.kind not in RECORDING_COMMANDS:
        return
    recording = uow.recordings.of_command(command_id)
    if recording is not None and recording.vehicle_id == vehicle_id:
        uow.recordings.save(answered(recording, command_id, moment, detail))
