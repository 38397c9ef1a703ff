"""Announcements to riders, as operators make them and as everybody reads them."""

from datetime import datetime
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, StringConstraints
from pydantic.config import JsonDict

from server.api.formats import FreeText, Moment, Name, StopId
from server.domain.service.announcements import (
    TEXT_CHARACTERS_MAX,
    Announcement,
    AnnouncementState,
    Audience,
)
from server.usecases.fleet.announcements import NewAnnouncement

# More than any campus has.
_NAMED_MAX = 500

AnnouncementText = Annotated[FreeText, StringConstraints(min_length=1, max_length=TEXT_CHARACTERS_MAX)]

BODY_EXAMPLE: JsonDict = {
    "text_zh": "图书馆站今天改到东侧上车。",
    "text_en": "Today shuttles stop at the east side of the library.",
    "audience": "stops",
    "stop_ids": ["library"],
    "vehicle_ids": [],
    "starts_at": None,
    "ends_at": "2026-09-01T16:00:00Z",
}
CURRENT_EXAMPLE: JsonDict = BODY_EXAMPLE | {
    "announcement_id": "announcement-3",
    "starts_at": "2026-09-01T08:00:00Z",
}


class AnnouncementBody(BaseModel):
    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": BODY_EXAMPLE})

    text_zh: AnnouncementText = Field(description="In Chinese.")
    text_en: AnnouncementText = Field(description="The same in English.")
    audience: Audience = Field(
        Audience.ALL,
        description=(
            "all: stop boards, the passenger page and shuttles. stops: boards, and passengers who go from or "
            "to there. shuttles: said aloud and shown in the shuttle, and shown to those who ride in it."
        ),
    )
    stop_ids: list[StopId] = Field([], max_length=_NAMED_MAX, description="Empty: all stops.")
    vehicle_ids: list[Name] = Field([], max_length=_NAMED_MAX, description="Empty: all shuttles.")
    starts_at: Moment | None = Field(None, description="Null: now.")
    ends_at: Moment | None = Field(None, description="Null: until it is ended.")


class CurrentAnnouncement(BaseModel):
    """What riders are told at this moment."""

    model_config = ConfigDict(json_schema_extra={"example": CURRENT_EXAMPLE})

    announcement_id: str
    text_zh: str
    text_en: str
    audience: Audience
    stop_ids: list[str] = Field(description="Of the audience `stops`; empty: all stops.")
    vehicle_ids: list[str] = Field(description="Of the audience `shuttles`; empty: all shuttles.")
    starts_at: datetime
    ends_at: datetime | None


class AnnouncementView(CurrentAnnouncement):
    """An announcement with its author and its state."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": CURRENT_EXAMPLE
            | {
                "state": "current",
                "made_by": "ines",
                "made_at": "2026-09-01T08:00:00Z",
                "ended_by": "",
                "ended_at": None,
            }
        }
    )

    state: AnnouncementState
    made_by: str
    made_at: datetime
    ended_by: str = Field(description="Empty if its time has passed, or has not.")
    ended_at: datetime | None = Field(description="When an operator ended it.")


def announcement_request(body: AnnouncementBody) -> NewAnnouncement:
    return NewAnnouncement(
        text_zh=body.text_zh,
        text_en=body.text_en,
        audience=body.audience,
        stop_ids=tuple(body.stop_ids),
        vehicle_ids=tuple(body.vehicle_ids),
        starts_at=body.starts_at,
        ends_at=body.ends_at,
    )


def current_announcement(announcement: Announcement) -> CurrentAnnouncement:
    return CurrentAnnouncement(
        announcement_id=announcement.announcement_id,
        text_zh=announcement.text_zh,
        text_en=announcement.text_en,
        audience=announcement.audience,
        stop_ids=list(announcement.stop_ids),
        vehicle_ids=list(announcement.vehicle_ids),
        starts_at=announcement.starts_at,
        ends_at=announcement.ends_at,
    )


def announcement_view(announcement: Announcement, now: datetime) -> AnnouncementView:
    return AnnouncementView(
        **current_announcement(announcement).model_dump(),
        state=announcement.state_at(now),
        made_by=announcement.made_by,
        made_at=announcement.made_at,
        ended_by=announcement.ended_by,
        ended_at=announcement.ended_at,
    )
