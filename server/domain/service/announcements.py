"""What operators tell riders: on stop boards, on the passenger page and in shuttles, for a time."""

from dataclasses import dataclass, replace
from datetime import datetime
from enum import StrEnum

from server.domain.errors import AnnouncementInvalid, AnnouncementOver

# What is read on a board from some metres away, and heard in one go in a shuttle.
TEXT_CHARACTERS_MAX = 280
# More would bury each other on a board.
STANDING_MAX = 20


class AnnouncementState(StrEnum):
    """scheduled: its time has not come; over: its time has passed, or an operator ended it."""

    SCHEDULED = "scheduled"
    CURRENT = "current"
    OVER = "over"


class Audience(StrEnum):
    """all: boards, passengers' phones and shuttles. stops, shuttles: these alone, and riders who use them."""

    ALL = "all"
    STOPS = "stops"
    SHUTTLES = "shuttles"


@dataclass(frozen=True, slots=True)
class Announcement:
    """A text for riders within [starts_at, ends_at).

    text_zh, text_en  the same in Chinese and English
    ends_at      None: until an operator ends it
    stop_ids     of the audience `stops`; empty: all stops
    vehicle_ids  of the audience `shuttles`; empty: all shuttles
    sent_at      when the shuttles that it addresses were told to say it; None before, and for no shuttles
    ended_by, ended_at  the operator who ended it early; "" and None else
    """

    campus_id: str
    announcement_id: str
    text_zh: str
    text_en: str
    starts_at: datetime
    ends_at: datetime | None
    audience: Audience
    stop_ids: tuple[str, ...]
    vehicle_ids: tuple[str, ...]
    made_by: str
    made_at: datetime
    sent_at: datetime | None = None
    ended_by: str = ""
    ended_at: datetime | None = None

    def state_at(self, now: datetime) -> AnnouncementState:
        if self.ended_at is not None or (self.ends_at is not None and self.ends_at <= now):
            return AnnouncementState.OVER
        return AnnouncementState.SCHEDULED if now < self.starts_at else AnnouncementState.CURRENT

    def is_at_stop(self, stop_id: str) -> bool:
        """It is shown on this stop's board."""
        if self.audience is Audience.SHUTTLES:
            return False
        return self.audience is Audience.ALL or not self.stop_ids or stop_id in self.stop_ids

    def is_in_vehicle(self, vehicle_id: str) -> bool:
        """It is said and shown in this shuttle."""
        if self.audience is Audience.STOPS:
            return False
        return self.audience is Audience.ALL or not self.vehicle_ids or vehicle_id in self.vehicle_ids


def require_sound(announcement: Announcement) -> None:
    """Raises AnnouncementInvalid."""
    for text in (announcement.text_zh, announcement.text_en):
        if not text.strip():
            raise AnnouncementInvalid("the announcement needs its text in Chinese and in English")
        if len(text) > TEXT_CHARACTERS_MAX:
            raise AnnouncementInvalid(f"a text has at most {TEXT_CHARACTERS_MAX} characters")
    if announcement.stop_ids and announcement.audience is not Audience.STOPS:
        raise AnnouncementInvalid("stops are named, but the audience is not `stops`")
    if announcement.vehicle_ids and announcement.audience is not Audience.SHUTTLES:
        raise AnnouncementInvalid("shuttles are named, but the audience is not `shuttles`")
    if announcement.ends_at is not None and announcement.ends_at <= announcement.starts_at:
        raise AnnouncementInvalid("the announcement ends before it begins")
    if announcement.ends_at is not None and announcement.ends_at <= announcement.made_at:
        raise AnnouncementInvalid("the end of the announcement has passed; give it a later end, or none")


def ended(announcement: Announcement, by: str, now: datetime) -> Announcement:
    """Raises AnnouncementOver."""
    if announcement.state_at(now) is AnnouncementState.OVER:
        raise AnnouncementOver(f"announcement {announcement.announcement_id} is over already")
    return replace(announcement, ended_by=by, ended_at=now)
