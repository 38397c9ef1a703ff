"""Incidents in the console: the title, the sound, groups, announcements to many, and the palette."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import OpenPage
from tests.e2e.console.test_rides import book, look
from tests.e2e.operator import sign_in
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real, pytest.mark.usefixtures("shuttle")]

# Counts the tones that the page plays.
_COUNT_TONES = """() => {
  window.tones = 0;
  const start = OscillatorNode.prototype.start;
  OscillatorNode.prototype.start = function (...when) { window.tones += 1; return start.apply(this, when); };
}"""


def console(open_page: OpenPage, server: ServerProcess, page_name: str) -> Page:
    page = open_page("/console")
    sign_in(page)
    expect(page.locator(".row").first).to_be_visible()
    page.goto(f"{server.origin}/console#/{page_name}")
    return page


def close_all(server: ServerProcess) -> None:
    for incident in server.http.get("/incidents").json():
        server.change("POST", f"/incidents/{incident['incident_id']}/close", {})


def call_help(server: ServerProcess) -> None:
    ride = book(server)
    server.change("POST", f"/rides/{ride['token']}/help", {"text": "where are you"})
    server.change("POST", f"/rides/{ride['token']}/cancel", {})


def test_the_title_counts_what_waits_and_the_sound_is_off_until_it_is_turned_on(
    open_page: OpenPage, server: ServerProcess
) -> None:
    close_all(server)
    page = console(open_page, server, "incidents")
    page.evaluate(_COUNT_TONES)
    expect(page).to_have_title("Campusloop console")
    call_help(server)
    expect(page).to_have_title("(1) Campusloop console")
    assert page.evaluate("window.tones") == 0
    # Turning it on lets the operator hear it once.
    page.get_by_label("Sound for new ones").check()
    assert page.evaluate("window.tones") == 2
    call_help(server)
    expect(page).to_have_title("(2) Campusloop console")
    page.wait_for_function("window.tones === 4")
    page.get_by_role("button", name="Acknowledge").first.click()
    expect(page).to_have_title("(1) Campusloop console")
    assert page.evaluate("window.tones") == 4
    close_all(server)


def test_incidents_are_grouped_by_kind_and_by_shuttle(
    open_page: OpenPage, server: ServerProcess, screenshots: Path | None
) -> None:
    close_all(server)
    call_help(server)
    call_help(server)
    page = console(open_page, server, "incidents")
    page.get_by_role("button", name="By kind").click()
    group = page.locator(".incident-group")
    expect(group).to_have_count(1)
    expect(group.locator("h2")).to_have_text(re.compile("2$"))
    expect(group.locator("article")).to_have_count(2)
    look(page, "console-incident-groups", screenshots)
    page.get_by_role("button", name="By shuttle").click()
    expect(page.locator("[data-group='shuttle-1'] article")).to_have_count(2)
    close_all(server)


def test_a_moved_lidar_is_named_with_what_to_do(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    close_all(server)
    page = console(open_page, server, "incidents")
    shuttle.name_lidar("lidar_moved", "front_left")
    card = page.locator("article[data-kind='vehicle_fault']")
    expect(card).to_contain_text("Lidar front_left looks moved.")
    expect(card.locator(".incident-action")).to_contain_text("have it calibrated again")
    shuttle.name_lidar("lidar_moved", "front_left", cleared=True)
    expect(card).to_have_count(0)


def test_one_announcement_goes_to_all_shuttles(
    open_page: OpenPage, server: ServerProcess, screenshots: Path | None
) -> None:
    page = console(open_page, server, "incidents")
    page.get_by_role("button", name="Announce to shuttles").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("textbox").fill("The road to the stadium is closed.")
    look(page, "console-announce-many", screenshots)
    dialog.get_by_label("All shuttles").uncheck()
    expect(dialog.get_by_role("button", name="Announce")).to_be_disabled()
    dialog.get_by_label("All shuttles").check()
    dialog.get_by_role("button", name="Announce").click()
    count = len(server.http.get("/vehicles").json())
    expect(dialog.get_by_role("status")).to_have_text(
        "Sent to 1 shuttle." if count == 1 else f"Sent to {count} shuttles."
    )


def open_palette(page: Page) -> None:
    page.keyboard.press("Control+k")
    expect(page.get_by_role("combobox", name="Page, shuttle or ride code")).to_be_focused()


def test_the_palette_opens_pages_shuttles_and_rides_by_keyboard(
    open_page: OpenPage, server: ServerProcess, screenshots: Path | None
) -> None:
    ride = book(server)
    page = console(open_page, server, "live")
    open_palette(page)
    page.keyboard.type("incid")
    look(page, "console-palette", screenshots)
    page.keyboard.press("Enter")
    expect(page.locator("h1")).to_have_text("Incidents")
    open_palette(page)
    page.keyboard.type("Shuttle 1")
    page.keyboard.press("Enter")
    expect(page.locator(".vehicle")).to_contain_text("Shuttle 1")
    open_palette(page)
    page.keyboard.type(ride["ride_code"])
    page.keyboard.press("Enter")
    expect(page.locator("h1")).to_have_text(f"Ride {ride['ride_code']}")
    page.keyboard.press("Alt+Shift+Digit2")
    expect(page.locator("h1")).to_have_text("Rides")
    open_palette(page)
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    server.change("POST", f"/rides/{ride['token']}/cancel", {})


def test_notes_on_an_incident_and_the_shift_log_stay(
    open_page: OpenPage, server: ServerProcess, screenshots: Path | None
) -> None:
    close_all(server)
    call_help(server)
    page = console(open_page, server, "incidents")
    card = page.locator("article").first
    card.get_by_text("Notes and history").click()
    card.get_by_label("Add a note").fill("A technician is on the way.")
    page.keyboard.press("Enter")
    expect(card.locator(".history")).to_contain_text("A technician is on the way.")
    expect(card.locator(".history li").first).to_contain_text("Opened")
    page.get_by_label("Add an entry for the next shift").fill("Shuttle 1 charges until nine.")
    page.keyboard.press("Enter")
    expect(page.locator(".shift-log .history")).to_contain_text("Shuttle 1 charges until nine.")
    look(page, "console-incident-notes", screenshots)
    page.reload()
    expect(page.locator(".shift-log .history")).to_contain_text("Shuttle 1 charges until nine.")
    close_all(server)
