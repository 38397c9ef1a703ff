"""What operators tell riders, on boards, phones and in shuttles."""

from typing import Annotated

from fastapi import APIRouter, Path, Query

from server.api.announcements.schemas import (
    AnnouncementBody,
    AnnouncementView,
    CurrentAnnouncement,
    announcement_request,
    announcement_view,
    current_announcement,
)
from server.api.commands import DispatchCommand
from server.api.formats import NAME_PATTERN
from server.api.paging import LIMIT_MAX, Page, microseconds_of, moment_of, paged
from server.api.problems import problems
from server.api.security.access import DRIVER_REFUSALS, READER_REFUSALS, Reader
from server.api.services import InjectedServices
from server.domain.errors import (
    AnnouncementInvalid,
    AnnouncementOver,
    AnnouncementUnknown,
    CampusUnknown,
    StopUnknown,
    VehicleUnknown,
)
from server.usecases.fleet import announcements
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/announcements", tags=["announcements"])

AnnouncementId = Annotated[str, Path(pattern=NAME_PATTERN, examples=["announcement-3"])]


@router.get("/current", operation_id="list_current_announcements")
async def list_current_announcements(services: InjectedServices) -> list[CurrentAnnouncement]:
    """What riders are told at this moment, the newest first."""

    def work(uow: UnitOfWork) -> list[CurrentAnnouncement]:
        return [current_announcement(one) for one in announcements.current(uow)]

    return await services.transactions.read(work)


@router.get("", operation_id="list_announcements", responses=paged(*READER_REFUSALS))
async def list_announcements(
    services: InjectedServices,
    _: Reader,
    page: Page,
    limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 100,
) -> list[AnnouncementView]:
    """Newest first, those that are over included."""
    ended = page.after(int, str)
    after = None if ended is None else (moment_of(ended[0]), str(ended[1]))

    def work(uow: UnitOfWork) -> list[AnnouncementView]:
        return [announcement_view(one, uow.now) for one in uow.announcements.newest(limit + 1, after)]

    found = await services.transactions.read(work)
    return page.first(found, limit, lambda one: (microseconds_of(one.made_at), one.announcement_id))


@router.post(
    "",
    operation_id="make_announcement",
    status_code=201,
    responses=problems(AnnouncementInvalid, StopUnknown, VehicleUnknown, CampusUnknown, *DRIVER_REFUSALS),
)
async def make_announcement(body: AnnouncementBody, command: DispatchCommand) -> AnnouncementView:
    """Riders see it from its beginning to its end. Shuttles that it addresses say it when it begins."""

    def work(uow: UnitOfWork) -> AnnouncementView:
        made = announcements.make(uow, announcement_request(body), command.by)
        return announcement_view(made, uow.now)

    return await command.transact(AnnouncementView, work)


@router.post(
    "/{announcement_id}/end",
    operation_id="end_announcement",
    responses=problems(AnnouncementUnknown, AnnouncementOver, *DRIVER_REFUSALS),
)
async def end_announcement(announcement_id: AnnouncementId, command: DispatchCommand) -> AnnouncementView:
    """Boards, phones and shuttles show it no longer; it stays in the list with who ended it."""

    def work(uow: UnitOfWork) -> AnnouncementView:
        return announcement_view(announcements.end(uow, announcement_id, command.by), uow.now)

    return await command.transact(AnnouncementView, work)
