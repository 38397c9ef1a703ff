"""Operators tell riders something, and end it. Shuttles that are addressed say it aloud when it begins."""

from dataclasses import dataclass, replace
from datetime import datetime

from server.domain.errors import AnnouncementInvalid, AnnouncementUnknown, StopUnknown
from server.domain.service.announcements import (
    STANDING_MAX,
    Announcement,
    AnnouncementState,
    Audience,
    ended,
    require_sound,
)
from server.usecases.fleet import campus
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.commands import send_command
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.server_events import record_event


@dataclass(frozen=True, slots=True)
class NewAnnouncement:
    """An operator's request. starts_at None means now, ends_at None until it is ended."""

    text_zh: str
    text_en: str
    audience: Audience = Audience.ALL
    stop_ids: tuple[str, ...] = ()
    vehicle_ids: tuple[str, ...] = ()
    starts_at: datetime | None = None
    ends_at: datetime | None = None


def current(uow: UnitOfWork) -> tuple[Announcement, ...]:
    """Those of this moment, the newest first."""
    standing = uow.announcements.standing(uow.now)
    found = [one for one in standing if one.state_at(uow.now) is AnnouncementState.CURRENT]
    return tuple(sorted(found, key=lambda one: (one.starts_at, one.announcement_id), reverse=True))


def make(uow: UnitOfWork, request: NewAnnouncement, by: str) -> Announcement:
    """Riders see it from its beginning on, and shuttles that it addresses say it then.

    Raises AnnouncementInvalid, StopUnknown, VehicleUnknown, CampusUnknown.
    """
    made = Announcement(
        campus_id=uow.campus_id,
        announcement_id=uow.ids.new_id("announcement"),
        text_zh=request.text_zh.strip(),
        text_en=request.text_en.strip(),
        starts_at=request.starts_at or uow.now,
        ends_at=request.ends_at,
        audience=request.audience,
        stop_ids=tuple(dict.fromkeys(request.stop_ids)),
        vehicle_ids=tuple(dict.fromkeys(request.vehicle_ids)),
        made_by=by,
        made_at=uow.now,
    )
    require_sound(made)
    known = {stop.stop_id for stop in campus.stops(uow)}
    for stop_id in made.stop_ids:
        if stop_id not in known:
            raise StopUnknown(f"the map has no stop {stop_id!r}; see /api/v1/stops")
    for vehicle_id in made.vehicle_ids:
        enrolled_vehicle(uow, vehicle_id)
    if len(uow.announcements.standing(uow.now)) >= STANDING_MAX:
        raise AnnouncementInvalid(f"{STANDING_MAX} announcements stand already; end one of them first")
    uow.announcements.add(made)
    _record_and_publish(uow, "announcement.made", made, by)
    begin_due(uow)
    return uow.announcements.get(made.announcement_id) or made


def end(uow: UnitOfWork, announcement_id: str, by: str) -> Announcement:
    """It is shown no longer. Raises AnnouncementUnknown, AnnouncementOver."""
    announcement = uow.announcements.get(announcement_id)
    if announcement is None:
        raise AnnouncementUnknown(f"there is no announcement {announcement_id}")
    over = ended(announcement, by, uow.now)
    uow.announcements.save(over)
    _record_and_publish(uow, "announcement.ended", over, by)
    if over.sent_at is not None:
        _say_next(uow, over, by)
    return over


def begin_due(uow: UnitOfWork) -> None:
    """Let shuttles say the announcements that have begun; each is sent to each shuttle once."""
    for announcement in reversed(current(uow)):
        if announcement.sent_at is None and announcement.audience is not Audience.STOPS:
            uow.announcements.save(replace(announcement, sent_at=uow.now))
            for vehicle in uow.vehicles.all():
                if announcement.is_in_vehicle(vehicle.vehicle_id):
                    _say(uow, vehicle.vehicle_id, announcement, announcement.made_by)
            uow.publish(topics.announcements(uow.campus_id))


def say_again(uow: UnitOfWork, vehicle_id: str) -> None:
    """Let a shuttle that has started say the newest of its announcements: it knows none of them any more."""
    here = (one for one in current(uow) if one.sent_at is not None and one.is_in_vehicle(vehicle_id))
    newest = next(here, None)
    waiting = {command.announcement_id for command in uow.vehicles.pending_commands(vehicle_id)}
    if newest is not None and newest.announcement_id not in waiting:
        _say(uow, vehicle_id, newest, newest.made_by)


def _say_next(uow: UnitOfWork, over: Announcement, by: str) -> None:
    """A shuttle shows one: in the place of this one the newest of the others, or none."""
    others = current(uow)
    for vehicle in uow.vehicles.all():
        if over.is_in_vehicle(vehicle.vehicle_id):
            others_here = (one for one in others if one.is_in_vehicle(vehicle.vehicle_id))
            _say(uow, vehicle.vehicle_id, next(others_here, None), by)


def _say(uow: UnitOfWork, vehicle_id: str, announcement: Announcement | None, by: str) -> None:
    """None: an empty text, by which the shuttle takes down what it shows."""
    if announcement is None:
        send_command(uow, vehicle_id, "announce", by)
    else:
        send_command(uow, vehicle_id, "announce", by, announcement.text_en, announcement.announcement_id)


def _record_and_publish(uow: UnitOfWork, name: str, announcement: Announcement, by: str) -> None:
    record_event(uow, name, announcement.announcement_id, by, announcement.text_en)
    uow.publish(topics.announcements(uow.campus_id))
