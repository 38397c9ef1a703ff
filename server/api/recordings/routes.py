"""Operators mark what a vehicle records, and start and stop named recordings."""

from typing import Annotated

from fastapi import APIRouter, Path, Query

from server.api.commands import RecordCommand
from server.api.formats import NAME_PATTERN, VehicleId
from server.api.paging import LIMIT_MAX, Page, microseconds_of, moment_of, paged
from server.api.problems import problems
from server.api.recordings.schemas import NewMark, NewRecording, RecordingView, recording_view
from server.api.security.access import DRIVER_REFUSALS, READER_REFUSALS, Reader
from server.api.services import InjectedServices
from server.api.vehicles.schemas import CommandView, command_view
from server.domain.errors import RecordingOver, RecordingUnderWay, RecordingUnknown, VehicleUnknown
from server.domain.record.recordings import Recording
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import recordings

router = APIRouter(tags=["runs"])

RecordingId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["command-9"])]


@router.get("/recordings", operation_id="list_recordings", responses=paged(*READER_REFUSALS))
async def list_recordings(
    services: InjectedServices,
    _: Reader,
    page: Page,
    vehicle_id: Annotated[str | None, Query(pattern=NAME_PATTERN)] = None,
    limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 100,
) -> list[RecordingView]:
    """Newest first."""
    ended = page.after(int, str)
    after = None if ended is None else (moment_of(ended[0]), str(ended[1]))

    def work(uow: UnitOfWork) -> list[RecordingView]:
        return [_view(uow, one) for one in uow.recordings.newest(vehicle_id, limit + 1, after)]

    found = await services.transactions.read(work)
    return page.first(found, limit, lambda one: (microseconds_of(one.started_at), one.recording_id))


@router.post(
    "/vehicles/{vehicle_id}/marks",
    operation_id="mark_recording",
    status_code=202,
    responses=problems(VehicleUnknown, *DRIVER_REFUSALS),
)
async def mark_recording(vehicle_id: VehicleId, request: NewMark, command: RecordCommand) -> CommandView:
    """Mark this moment in what the vehicle records, with a note.

    A vehicle that is out of reach writes the mark into its file when it is back; `state` stays pending.
    """
    return await command.transact(
        CommandView, lambda uow: command_view(recordings.mark(uow, vehicle_id, request.note, command.by))
    )


@router.post(
    "/vehicles/{vehicle_id}/recordings",
    operation_id="start_recording",
    status_code=202,
    responses=problems(VehicleUnknown, RecordingUnderWay, *DRIVER_REFUSALS),
)
async def start_recording(
    vehicle_id: VehicleId, request: NewRecording, command: RecordCommand
) -> RecordingView:
    """Begin a recording with a name. The vehicle records always: this one begins with a file of its own."""
    return await command.transact(
        RecordingView, lambda uow: _view(uow, recordings.start(uow, vehicle_id, request.name, command.by))
    )


@router.post(
    "/vehicles/{vehicle_id}/recordings/{recording_id}/stop",
    operation_id="stop_recording",
    status_code=202,
    responses=problems(VehicleUnknown, RecordingUnknown, RecordingOver, *DRIVER_REFUSALS),
)
async def stop_recording(
    vehicle_id: VehicleId, recording_id: RecordingId, command: RecordCommand
) -> RecordingView:
    """End it. Its last file ends here and is uploaded at once; the vehicle goes on recording."""
    return await command.transact(
        RecordingView, lambda uow: _view(uow, recordings.stop(uow, vehicle_id, recording_id, command.by))
    )


def _view(uow: UnitOfWork, recording: Recording) -> RecordingView:
    return recording_view(recording, recordings.files_of(uow, recording))
