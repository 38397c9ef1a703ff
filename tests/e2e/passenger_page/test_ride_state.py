"""What a phone says of a ride from the booking to its end: in the page, in its title, and by vibration."""

import re

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.operator import sign_in
from tests.e2e.passenger import book, cancel, fill_booking
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess
from tests.e2e.targets import small_targets

pytestmark = [pytest.mark.browser, pytest.mark.real]

QUICK_MPS = 60.0
SOON_MS = 90_000
NOTE_VIBRATION = "window.pulses = []; navigator.vibrate = (pattern) => window.pulses.push(pattern) > 0;"


def with_vibration_noted(page: Page) -> Page:
    """The page again, on a phone that notes how it vibrates."""
    page.add_init_script(NOTE_VIBRATION)
    page.reload()
    return page


def test_a_waiting_passenger_sees_a_range_of_minutes_and_the_seats_left(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", **PHONE)
    shuttle.speed_mps = 0.0
    book(page, "Main Library", "Gymnasium")
    expect(page.locator("h1")).to_contain_text(
        re.compile(r"Shuttle 1 arrives (in \d+ to \d+|within \d+) minutes")
    )
    expect(page).to_have_title(re.compile(r"^\d+(–\d+)? min · Campus shuttle$"))
    expect(page.locator(".stub")).to_contain_text(re.compile(r"\b[1-5] seats? left"))
    page.get_by_role("button", name="中文").click()
    expect(page.locator("h1")).to_contain_text(re.compile(r"(\d+–\d+ 分钟后|\d+ 分钟内)到达"))
    expect(page).to_have_title(re.compile(r"^\d+(–\d+)? 分钟 · "))
    expect(page.locator(".stub")).to_contain_text(re.compile(r"余 [1-5] 座"))
    page.get_by_role("button", name="EN").click()
    cancel(page)
    expect(page).to_have_title("Campus shuttle")


def test_the_title_and_one_vibration_say_that_the_shuttle_is_here_and_the_ticket_names_it_to_the_end(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = with_vibration_noted(open_page("/", **PHONE))
    shuttle.speed_mps = 0.0
    book(page, "Main Library", "Gymnasium")
    assert page.evaluate("window.pulses") == []
    shuttle.speed_mps = QUICK_MPS
    expect(page).to_have_title("Here · Campus shuttle", timeout=SOON_MS)
    assert len(page.evaluate("window.pulses")) == 1
    shuttle.speed_mps = 0.5
    page.get_by_role("button", name="I’m on board").click()
    expect(page.locator("h1")).to_contain_text(re.compile(r"You arrive (in \d+ to \d+|within \d+) minutes"))
    expect(page).to_have_title("Next stop · Campus shuttle", timeout=SOON_MS)
    shuttle.speed_mps = QUICK_MPS
    expect(page).to_have_title("Arrived · Campus shuttle", timeout=SOON_MS)
    page.get_by_role("button", name="I’m off").click()
    expect(page.get_by_role("heading", name="Ride completed")).to_be_visible()
    expect(page.locator(".stub")).to_contain_text("Shuttle 1")
    assert len(page.evaluate("window.pulses")) == 1


def test_who_has_switched_vibration_off_is_left_in_peace_also_later(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = with_vibration_noted(open_page("/", **PHONE))
    shuttle.speed_mps = 0.0
    book(page, "Main Library", "Gymnasium")
    page.get_by_label("Vibrate when the shuttle arrives").uncheck()
    page.reload()
    expect(page.get_by_label("Vibrate when the shuttle arrives")).not_to_be_checked()
    shuttle.speed_mps = QUICK_MPS
    expect(page).to_have_title("Here · Campus shuttle", timeout=SOON_MS)
    assert page.evaluate("window.pulses") == []
    cancel(page)


def test_who_was_refused_is_told_when_a_shuttle_is_free_and_books_it_by_one_tap(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    page = with_vibration_noted(open_page("/", **PHONE))
    page.clock.install()
    server.change("POST", f"/vehicles/{shuttle.vehicle_id}/recall")
    try:
        fill_booking(page, "Main Library", "Gymnasium")
        page.get_by_role("button", name="Book the ride").click()
        expect(page.get_by_role("heading", name="No shuttle can take this ride")).to_be_visible()
        page.get_by_role("button", name="Tell me when a shuttle is free").click()
        expect(page.get_by_text("This page looks for a free shuttle.")).to_be_visible()
        expect(page.locator(".button.main:visible")).to_have_count(1)
    finally:
        server.change("POST", f"/vehicles/{shuttle.vehicle_id}/release")
    page.clock.run_for(20_000)
    book_it = page.get_by_role("button", name=re.compile(r"Book it: pickup at about \d\d:\d\d"))
    expect(book_it).to_be_visible()
    expect(page).to_have_title("Free now · Campus shuttle")
    # It is the one strong button of the page.
    expect(page.locator(".button.main:visible")).to_have_count(1)
    assert len(page.evaluate("window.pulses")) == 1
    page.get_by_role("button", name="中文").click()
    expect(page.get_by_role("button", name=re.compile("立即预约"))).to_be_visible()
    page.get_by_role("button", name="EN").click()
    book_it.click()
    expect(page.locator("[data-boarding-code]")).to_be_visible()
    cancel(page)


def test_a_rating_and_a_lost_umbrella_reach_the_operators_and_stand_on_the_ticket(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", **PHONE)
    shuttle.speed_mps = QUICK_MPS
    code = book(page, "Main Library", "Gymnasium")
    for tap in ("I’m on board", "I’m off"):
        expect(page.get_by_role("button", name=tap)).to_be_enabled(timeout=SOON_MS)
        page.get_by_role("button", name=tap).click()
    expect(page.get_by_role("heading", name="Ride completed")).to_be_visible()
    expect(page.get_by_role("button", name="Send")).to_be_disabled()
    page.get_by_title("4 of 5: good").click()
    page.get_by_label("Left something in the shuttle?").fill("A blue umbrella")
    assert small_targets(page, 48) == []
    page.get_by_role("button", name="Send").click()
    expect(page.get_by_text("Thank you. The operators can read it.")).to_be_visible()
    page.reload()
    expect(page.get_by_role("radio", name="4 of 5: good")).to_be_checked()
    expect(page.get_by_label("Left something in the shuttle?")).to_have_value("A blue umbrella")
    page.get_by_role("button", name="中文").click()
    expect(page.get_by_text("本次乘车感觉如何？")).to_be_visible()
    console = open_page("/console")
    sign_in(console)
    console.get_by_role("link", name="Rides").click()
    console.get_by_role("button", name="All", exact=True).click()
    told = console.locator(f'[data-ride="{code}"] [data-feedback]')
    expect(told).to_contain_text("Rated 4 of 5")
    expect(told).to_contain_text("A blue umbrella")
