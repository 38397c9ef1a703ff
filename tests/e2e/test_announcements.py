"""What operators tell riders: written in the console, it comes to open boards and phones, and goes."""

import re
from datetime import UTC, datetime, timedelta

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.operator import show_vehicle, sign_in
from tests.e2e.passenger import book, cancel
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real]

ENGLISH, CHINESE = "Board at the east side today", "今天在东侧上车"


def write(page: Page, english: str, chinese: str) -> None:
    page.get_by_label("Text in Chinese").fill(chinese)
    page.get_by_label("Text in English").fill(english)


def test_what_is_written_in_the_console_comes_to_open_pages_and_goes_when_it_is_ended(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    shuttle.speed_mps = 0.0
    stops = {stop["name_en"]: stop["stop_id"] for stop in server.http.get("/stops").json()}
    board = open_page(f"/board/{stops['Yongfu Temple']}?lang=en")
    ticket, form = open_page("/", **PHONE), open_page("/", **PHONE)
    book(ticket, "Yongfu Temple", "Gymnasium")
    expect(form.get_by_role("button", name="Choose both stops first")).to_be_visible()
    console = open_page("/console#/service")
    sign_in(console)
    card = console.locator(".announcements")
    write(console, ENGLISH, CHINESE)
    card.get_by_role("button", name="Preview").click()
    question = console.get_by_role("dialog")
    expect(question.locator("[data-preview=en]")).to_contain_text(ENGLISH)
    expect(question.locator("[data-preview=zh]")).to_contain_text(CHINESE)
    question.get_by_role("button", name="Back").click()
    expect(board.get_by_text(ENGLISH)).to_have_count(0)
    card.get_by_role("button", name="Preview").click()
    question.get_by_role("button", name="Announce to riders").click()
    row = card.locator("[data-announcement]").first
    expect(row).to_contain_text("shown now")
    expect(row).to_contain_text("operator")
    for page in (board, ticket, form):
        expect(page.get_by_text(ENGLISH)).to_be_visible()
    expect(board.get_by_text(CHINESE)).to_be_visible()
    expect(console.get_by_label("Text in English")).to_have_value("")
    row.get_by_role("button", name="End").click()
    expect(row).to_contain_text("ended by operator")
    for page in (board, ticket, form):
        expect(page.get_by_text(ENGLISH)).to_have_count(0)
    cancel(ticket)


def test_one_to_a_stop_is_shown_there_and_to_who_goes_there_and_ends_by_itself(
    open_page: OpenPage, server: ServerProcess
) -> None:
    stops = {stop["name_en"]: stop["stop_id"] for stop in server.http.get("/stops").json()}
    here = open_page(f"/board/{stops['Yongfu Temple']}?lang=en")
    elsewhere = open_page(f"/board/{stops['Gymnasium']}?lang=en")
    phone, other = (open_page(f"/?from={stops[name]}", **PHONE) for name in ("Yongfu Temple", "Gymnasium"))
    body = {
        "text_zh": CHINESE,
        "text_en": ENGLISH,
        "audience": "stops",
        "stop_ids": [stops["Yongfu Temple"]],
        "ends_at": (datetime.now(UTC) + timedelta(seconds=15)).isoformat(),
    }
    server.change("POST", "/announcements", body)
    expect(here.get_by_text(ENGLISH)).to_be_visible()
    expect(phone.get_by_text(ENGLISH)).to_be_visible()
    for page in (elsewhere, other):
        expect(page.get_by_role("heading").first).to_be_visible()
        expect(page.get_by_text(ENGLISH)).to_have_count(0)
    for page in (here, phone):
        expect(page.get_by_text(ENGLISH)).to_have_count(0, timeout=45_000)


def test_one_to_shuttles_is_said_there_and_bad_ones_are_refused_with_the_reason(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    console = open_page("/console#/service", allowed=(400,))
    sign_in(console)
    card = console.locator(".announcements")
    expect(card.get_by_role("button", name="Preview")).to_be_disabled()
    write(console, "Fasten your belts", "请系安全带")
    card.get_by_label("To", exact=True).select_option("shuttles")
    card.get_by_label("Shuttle 1").check()
    card.get_by_label(re.compile("^Until")).fill("2020-01-01T08:00")
    card.get_by_role("button", name="Preview").click()
    question = console.get_by_role("dialog")
    expect(question).to_contain_text("Shuttle 1")
    question.get_by_role("button", name="Announce to riders").click()
    expect(question.get_by_role("alert")).to_contain_text("The end must be after the beginning")
    question.get_by_role("button", name="Back").click()
    card.get_by_label(re.compile("^Until")).fill("")
    card.get_by_role("button", name="Preview").click()
    question.get_by_role("button", name="Announce to riders").click()
    row = card.locator("[data-announcement]").first
    expect(row).to_contain_text("Fasten your belts")
    open_vehicle = open_page("/console")
    sign_in(open_vehicle)
    expect(show_vehicle(open_vehicle, "Shuttle 1").locator(".spoken")).to_contain_text("Fasten your belts")
    row.get_by_role("button", name="End").click()
    expect(row).to_contain_text("over")
