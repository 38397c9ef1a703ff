"""Announcements to riders: which boards show them, which shuttles say them, and when they go."""

from dataclasses import replace
from datetime import timedelta

import pytest

from server.domain.errors import AnnouncementInvalid, StopUnknown, VehicleUnknown
from server.domain.service.announcements import STANDING_MAX, Announcement, Audience
from server.usecases.fleet import announcements, vehicle_sessions
from server.usecases.fleet.announcements import NewAnnouncement
from server.usecases.fleet.stop_boards import stop_board
from server.usecases.fleet.vehicle_sessions import HelloFacts
from server.usecases.orders import outbox
from server.usecases.orders.outbox import UNTIL_ENDED_NS
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.shipped_maps import shipped_map

ALL = NewAnnouncement("今天在东侧上车", "Board at the east side today")
IN_SHUTTLES = NewAnnouncement("请系安全带", "Fasten your belts", Audience.SHUTTLES)


@pytest.fixture
def campus() -> CampusUnderTest:
    campus = CampusUnderTest(shipped_map("snow-lion"))
    for vehicle_id in ("shuttle-1", "shuttle-2"):
        campus.enrol(vehicle_id)
    return campus


def made(campus: CampusUnderTest, request: NewAnnouncement) -> Announcement:
    return campus.do(lambda uow: announcements.make(uow, request, "ann"))


def on_board(campus: CampusUnderTest, stop_id: str) -> list[str]:
    return [one.text_en for one in campus.read(lambda uow: stop_board(uow, stop_id)).announcements]


def said(campus: CampusUnderTest, vehicle_id: str) -> list[tuple[str, str, int]]:
    """What the vehicle gets from the server now."""
    commands = campus.do(lambda uow: outbox.outbox_of(uow, vehicle_id)).commands
    return [(one.text, one.text_zh, one.shown_until_ns) for one in commands]


def starts(campus: CampusUnderTest, vehicle_id: str, boot_id: str) -> None:
    """Its agent says hello."""
    hello = HelloFacts(vehicle_id, boot_id, "0.1", "snow_lion", "", (), None, 6, 0)
    campus.do(lambda uow: vehicle_sessions.open_session(uow, hello))


def pass_s(campus: CampusUnderTest, seconds: float) -> None:
    campus.clock.advance(seconds)
    campus.do(announcements.begin_due)


def test_one_to_all_is_on_every_board_and_said_once_in_every_shuttle(campus: CampusUnderTest) -> None:
    announcement = made(campus, ALL)
    assert on_board(campus, "NN20") == on_board(campus, "C6") == [ALL.text_en]
    words = [(ALL.text_en, ALL.text_zh, UNTIL_ENDED_NS)]
    assert said(campus, "shuttle-1") == said(campus, "shuttle-2") == words
    pass_s(campus, 5.0)
    assert said(campus, "shuttle-1") == words, "sent once"
    campus.do(lambda uow: announcements.end(uow, announcement.announcement_id, "bob"))
    assert on_board(campus, "NN20") == []
    assert said(campus, "shuttle-1") == [("", "", 0)], "a shuttle that never heard it does not say it now"


def test_one_to_stops_is_on_their_boards_alone_and_in_no_shuttle(campus: CampusUnderTest) -> None:
    made(campus, NewAnnouncement("a", "b", Audience.STOPS, ("C6",)))
    assert (on_board(campus, "NN20"), on_board(campus, "C6")) == ([], ["b"])
    assert said(campus, "shuttle-1") == []


def test_one_to_a_shuttle_begins_and_ends_by_itself(campus: CampusUnderTest) -> None:
    begins = campus.clock.now() + timedelta(seconds=60)
    request = NewAnnouncement(
        "请系安全带",
        "Fasten your belts",
        Audience.SHUTTLES,
        vehicle_ids=("shuttle-2",),
        starts_at=begins,
        ends_at=begins + timedelta(seconds=60),
    )
    made(campus, request)
    pass_s(campus, 59.0)
    assert said(campus, "shuttle-2") == []
    pass_s(campus, 1.0)
    until_ns = round((begins.timestamp() + 60.0) * 1e9)
    assert said(campus, "shuttle-2") == [("Fasten your belts", "请系安全带", until_ns)]
    assert (said(campus, "shuttle-1"), on_board(campus, "C6")) == ([], [])
    pass_s(campus, 60.0)
    assert said(campus, "shuttle-2") == [], "it is over before the shuttle was in reach"


def test_a_shuttle_goes_back_to_the_older_announcement_when_the_newer_one_is_ended(
    campus: CampusUnderTest,
) -> None:
    made(campus, ALL)
    pass_s(campus, 1.0)
    newer = made(campus, IN_SHUTTLES)
    assert [text for text, _, _ in said(campus, "shuttle-1")] == [ALL.text_en, IN_SHUTTLES.text_en]
    campus.do(lambda uow: announcements.end(uow, newer.announcement_id, "bob"))
    assert [text for text, _, _ in said(campus, "shuttle-1")] == [ALL.text_en, ALL.text_en]


def test_a_shuttle_that_starts_says_what_stands_and_says_it_once(campus: CampusUnderTest) -> None:
    made(campus, ALL)
    pass_s(campus, 1.0)
    made(campus, IN_SHUTTLES)
    campus.enrol("shuttle-3")
    assert said(campus, "shuttle-3") == []
    starts(campus, "shuttle-3", "boot-1")
    assert [text for text, _, _ in said(campus, "shuttle-3")] == [IN_SHUTTLES.text_en]
    starts(campus, "shuttle-3", "boot-1")
    starts(campus, "shuttle-3", "boot-2")
    assert [text for text, _, _ in said(campus, "shuttle-3")] == [IN_SHUTTLES.text_en], "it waits already"


def test_a_shuttle_that_has_said_it_says_it_again_after_a_start(campus: CampusUnderTest) -> None:
    starts(campus, "shuttle-1", "boot-1")
    made(campus, ALL)
    (command,) = campus.do(lambda uow: outbox.outbox_of(uow, "shuttle-1")).commands
    answered = campus.read(lambda uow: uow.vehicles.command(command.command_id))
    assert answered is not None
    campus.do(lambda uow: uow.vehicles.save_command(replace(answered, state="done")))
    starts(campus, "shuttle-1", "boot-1")
    assert said(campus, "shuttle-1") == [], "a lost link is no start"
    starts(campus, "shuttle-1", "boot-2")
    assert [text for text, _, _ in said(campus, "shuttle-1")] == [ALL.text_en]


def test_unknown_stops_and_shuttles_and_too_many_are_refused_and_nothing_is_kept(
    campus: CampusUnderTest,
) -> None:
    with pytest.raises(StopUnknown, match="nowhere"):
        made(campus, NewAnnouncement("a", "b", Audience.STOPS, ("nowhere",)))
    with pytest.raises(VehicleUnknown):
        made(campus, NewAnnouncement("a", "b", Audience.SHUTTLES, vehicle_ids=("ghost",)))
    assert campus.read(lambda uow: uow.announcements.newest(10)) == ()
    for _ in range(STANDING_MAX):
        made(campus, NewAnnouncement("a", "b", Audience.STOPS))
    with pytest.raises(AnnouncementInvalid, match="end one"):
        made(campus, ALL)
    assert len(campus.read(lambda uow: uow.announcements.newest(100))) == STANDING_MAX
