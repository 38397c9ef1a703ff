"""Stop boards: what a screen at a stop shows, and the code that leads its reader to a booking from there."""

import io
from datetime import datetime
from typing import Annotated
from urllib.parse import quote

import segno
from fastapi import APIRouter, Path, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from server.api.announcements.schemas import (
    CURRENT_EXAMPLE,
    CurrentAnnouncement,
    current_announcement,
)
from server.api.campus.schemas import STOP_EXAMPLE, StopView, stop_view
from server.api.formats import StopId
from server.api.problems import problems
from server.api.services import InjectedServices, Services
from server.domain.errors import CampusUnknown, StopUnknown
from server.domain.planning.eta_ranges import ExpectedRange
from server.domain.service.timetable import DepartureState
from server.usecases.fleet import campus, stop_boards
from server.usecases.fleet.stop_boards import BoardDeparture, BoardShuttle, StopBoard
from server.usecases.ports.unit_of_work import UnitOfWork

router = APIRouter(prefix="/stops", tags=["campus"])

BoardStopId = Annotated[StopId, Path(examples=["library"])]
# Blank modules around the code, as ISO/IEC 18004 wants them.
QUIET_MODULES = 4


class RangeView(BaseModel):
    """In 9 of 10 cases between these."""

    earliest: datetime
    latest: datetime


class BoardDepartureView(BaseModel):
    """A trip of the timetable that leaves this stop."""

    trip_id: str
    leave_at: datetime = Field(description="By the timetable; never earlier.")
    to_stop: str = Field(description="Where the trip ends.")
    to_name: str
    to_name_en: str
    state: DepartureState
    vehicle_name: str = Field(description="Empty until the trip has a shuttle.")
    expected: RangeView | None = Field(description="Null until it has one, and while no time can be told.")
    is_here: bool
    is_last: bool = Field(description="No later trip of the day leaves this stop.")
    seats_left: int | None


class BoardShuttleView(BaseModel):
    """A shuttle that comes for riders who booked."""

    vehicle_name: str
    expected: RangeView | None = Field(description="Null while it stands or is out of reach.")
    is_here: bool
    seats_left: int | None


class BoardClosureView(BaseModel):
    """A closed road that concerns this stop, now or in the next six hours."""

    reason: str = Field(description="As the operators gave it; may be empty.")
    starts_at: datetime
    ends_at: datetime | None
    is_served: bool = Field(description="Shuttles come to this stop all the same.")


class BoardView(BaseModel):
    """The next departures of a stop. It names no rider."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "stop": STOP_EXAMPLE,
                "timezone": "Asia/Shanghai",
                "now": "2026-09-01T08:14:31Z",
                "departures": [
                    {
                        "trip_id": "evening-3",
                        "leave_at": "2026-09-01T08:20:00Z",
                        "to_stop": "east-gate",
                        "to_name": "东门",
                        "to_name_en": "East Gate",
                        "state": "assigned",
                        "vehicle_name": "Shuttle 1",
                        "expected": {"earliest": "2026-09-01T08:20:00Z", "latest": "2026-09-01T08:21:30Z"},
                        "is_here": False,
                        "is_last": False,
                        "seats_left": 4,
                    }
                ],
                "shuttles": [],
                "open_now": True,
                "opens_next": "2026-09-01T08:14:31Z",
                "closes_at": "2026-09-01T14:00:00Z",
                "holiday": None,
                "closures": [
                    {
                        "reason": "Road works",
                        "starts_at": "2026-09-01T08:00:00Z",
                        "ends_at": None,
                        "is_served": False,
                    }
                ],
                "announcements": [CURRENT_EXAMPLE],
                "book_url": "https://campus.example/?from=library",
            }
        }
    )

    stop: StopView
    timezone: str
    now: datetime = Field(description="The server's clock; all times refer to it.")
    departures: list[BoardDepartureView] = Field(description="By time; those that have left are not shown.")
    shuttles: list[BoardShuttleView] = Field(description="Those that stand here first, then by time.")
    open_now: bool
    opens_next: datetime | None
    closes_at: datetime | None
    holiday: str | None
    closures: list[BoardClosureView] = Field(description="By their beginning.")
    announcements: list[CurrentAnnouncement] = Field(description="Of the operators, the newest first.")
    book_url: str = Field(description="Where a ride from this stop is booked.")


@router.get("/{stop_id}/board", operation_id="get_stop_board", responses=problems(StopUnknown, CampusUnknown))
async def get_stop_board(stop_id: BoardStopId, services: InjectedServices, request: Request) -> BoardView:
    """What a screen at this stop shows: the next trips of the timetable, and the shuttles that come.

    `/ws/board/STOP` sends the same whenever it changes.
    """
    return await read_board(services, stop_id, str(request.base_url))


async def read_board(services: Services, stop_id: str, base_url: str) -> BoardView:
    """base_url: by which the screen reaches us. Raises StopUnknown, CampusUnknown."""
    book_url = _book_url(services.settings.public_url, base_url, stop_id)

    def work(uow: UnitOfWork) -> BoardView:
        board = stop_boards.stop_board(uow, stop_id)
        named = {stop.stop_id: (stop.name, stop.name_en) for stop in campus.stops(uow)}
        return _board_view(board, named, book_url)

    return await services.transactions.read(work)


@router.get(
    "/{stop_id}/board/code",
    operation_id="get_stop_code",
    response_class=Response,
    responses=problems(StopUnknown, CampusUnknown)
    | {200: {"description": "A picture.", "content": {"image/svg+xml": {"schema": {"type": "string"}}}}},
)
async def get_stop_code(stop_id: BoardStopId, services: InjectedServices, request: Request) -> Response:
    """A QR code of the address at which a ride from this stop is booked, for screens and for print."""
    await services.transactions.read(lambda uow: stop_boards.stop_of(uow, stop_id))
    picture = io.BytesIO()
    address = _book_url(services.settings.public_url, str(request.base_url), stop_id)
    segno.make(address, error="m", micro=False).save(
        picture, kind="svg", border=QUIET_MODULES, dark="#000", light="#fff", omitsize=True
    )
    return Response(picture.getvalue(), media_type="image/svg+xml", headers={"Cache-Control": "no-cache"})


def _book_url(public_url: str, base_url: str, stop_id: str) -> str:
    """On the address by which the screen itself reaches us, where no other one is set."""
    origin = public_url.rstrip("/") or base_url.rstrip("/")
    return f"{origin}/?from={quote(stop_id, safe='')}"


def _board_view(board: StopBoard, named: dict[str, tuple[str, str]], book_url: str) -> BoardView:
    return BoardView(
        stop=stop_view(board.stop),
        timezone=board.timezone,
        now=board.now,
        departures=[_departure(one, *named.get(one.to_stop, ("", ""))) for one in board.departures],
        shuttles=[_shuttle(one) for one in board.shuttles],
        open_now=board.open_now,
        opens_next=board.opens_next,
        closes_at=board.closes_at,
        holiday=board.holiday,
        closures=[
            BoardClosureView(
                reason=one.reason, starts_at=one.starts_at, ends_at=one.ends_at, is_served=one.is_served
            )
            for one in board.closures
        ],
        announcements=[current_announcement(one) for one in board.announcements],
        book_url=book_url,
    )


def _departure(row: BoardDeparture, to_name: str, to_name_en: str) -> BoardDepartureView:
    return BoardDepartureView(
        trip_id=row.trip_id,
        leave_at=row.leave_at,
        to_stop=row.to_stop,
        to_name=to_name,
        to_name_en=to_name_en,
        state=row.state,
        vehicle_name=row.vehicle_name,
        expected=_range(row.expected),
        is_here=row.is_here,
        is_last=row.is_last,
        seats_left=row.seats_left,
    )


def _shuttle(row: BoardShuttle) -> BoardShuttleView:
    return BoardShuttleView(
        vehicle_name=row.vehicle_name,
        expected=_range(row.expected),
        is_here=row.is_here,
        seats_left=row.seats_left,
    )


def _range(given: ExpectedRange | None) -> RangeView | None:
    return None if given is None else RangeView(earliest=given.earliest, latest=given.latest)
