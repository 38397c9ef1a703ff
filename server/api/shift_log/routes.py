"""The log that one shift of operators leaves to the next."""

from typing import Annotated

from fastapi import APIRouter, Depends, Query

from server.api.commands import IncidentCommand
from server.api.incidents.schemas import NoteRequest, NoteView, note_view
from server.api.problems import problems
from server.api.security.access import LOOKING_REFUSALS, OPERATOR_REFUSALS, Actor, looking
from server.api.security.permissions import READ_NOTES
from server.api.services import InjectedServices
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import notes

router = APIRouter(prefix="/shift-log", tags=["incidents"])


@router.get("", operation_id="read_shift_log", responses=problems(*LOOKING_REFUSALS))
async def read_shift_log(
    services: InjectedServices,
    _: Annotated[Actor, Depends(looking(READ_NOTES))],
    limit: Annotated[int, Query(ge=1, le=500)] = 100,
) -> list[NoteView]:
    """The latest entries, oldest first."""
    found = await services.transactions.read(lambda uow: notes.shift_log(uow, limit))
    return [note_view(event) for event in found]


@router.post("", operation_id="write_shift_log", status_code=201, responses=problems(*OPERATOR_REFUSALS))
async def write_shift_log(request: NoteRequest, command: IncidentCommand) -> NoteRequest:
    """An entry in the operator's name, for the next shift."""

    def work(uow: UnitOfWork) -> NoteRequest:
        notes.note_in_shift_log(uow, request.text, command.by)
        return request

    return await command.transact(NoteRequest, work)
