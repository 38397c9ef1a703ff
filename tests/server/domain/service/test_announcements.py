"""An announcement's life: sound or not, its time, its end, and who gets it."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.domain.errors import AnnouncementInvalid, AnnouncementOver
from server.domain.service.announcements import (
    TEXT_CHARACTERS_MAX,
    Announcement,
    AnnouncementState,
    Audience,
    ended,
    require_sound,
)

NOON = datetime(2026, 11, 23, 12, 0, tzinfo=UTC)
HOUR, MOMENT = timedelta(hours=1), timedelta(microseconds=1)
EAST_SIDE = Announcement(
    "snow-lion", "a-1", "今天在东侧", "East side", NOON, NOON + HOUR, Audience.ALL, (), (), "ann", NOON - HOUR
)


@pytest.mark.parametrize(
    ("now", "state"),
    [
        (NOON - MOMENT, AnnouncementState.SCHEDULED),
        (NOON, AnnouncementState.CURRENT),
        (NOON + HOUR - MOMENT, AnnouncementState.CURRENT),
        (NOON + HOUR, AnnouncementState.OVER),
    ],
)
def test_it_is_told_from_its_beginning_until_its_end(now: datetime, state: AnnouncementState) -> None:
    assert EAST_SIDE.state_at(now) is state


@given(before=st.booleans(), later_s=st.floats(0.0, 1e7))
def test_one_that_was_ended_does_not_come_back(before: bool, later_s: float) -> None:
    at = NOON - HOUR if before else NOON
    over = ended(EAST_SIDE, "bob", at)
    assert (over.ended_by, over.ended_at) == ("bob", at)
    assert over.state_at(at + timedelta(seconds=later_s)) is AnnouncementState.OVER
    with pytest.raises(AnnouncementOver, match="a-1"):
        ended(over, "ann", at)


def test_one_without_an_end_stays_until_it_is_ended() -> None:
    assert replace(EAST_SIDE, ends_at=None).state_at(NOON + 10_000 * HOUR) is AnnouncementState.CURRENT


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"text_zh": " "}, "Chinese and in English"),
        ({"text_en": ""}, "Chinese and in English"),
        ({"text_en": "a" * (TEXT_CHARACTERS_MAX + 1)}, "at most"),
        ({"ends_at": NOON}, "ends before it begins"),
        ({"starts_at": NOON - 3 * HOUR, "ends_at": NOON - 2 * HOUR}, "has passed"),
        ({"stop_ids": ("C6",)}, "stops are named"),
        ({"audience": Audience.STOPS, "vehicle_ids": ("v",)}, "shuttles are named"),
    ],
)
def test_what_contradicts_itself_is_refused(changes: dict[str, object], why: str) -> None:
    with pytest.raises(AnnouncementInvalid, match=why):
        require_sound(replace(EAST_SIDE, **changes))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("audience", "stop_ids", "vehicle_ids", "at_stops", "in_shuttles"),
    [
        (Audience.ALL, (), (), {"A", "B"}, {"v", "w"}),
        (Audience.STOPS, (), (), {"A", "B"}, set()),
        (Audience.STOPS, ("A",), (), {"A"}, set()),
        (Audience.SHUTTLES, (), (), set(), {"v", "w"}),
        (Audience.SHUTTLES, (), ("w",), set(), {"w"}),
    ],
)
def test_the_audience_alone_gets_it(
    audience: Audience,
    stop_ids: tuple[str, ...],
    vehicle_ids: tuple[str, ...],
    at_stops: set[str],
    in_shuttles: set[str],
) -> None:
    one = replace(EAST_SIDE, audience=audience, stop_ids=stop_ids, vehicle_ids=vehicle_ids)
    assert {stop_id for stop_id in "AB" if one.is_at_stop(stop_id)} == at_stops
    assert {vehicle_id for vehicle_id in "vw" if one.is_in_vehicle(vehicle_id)} == in_shuttles
