"""The passenger page while a shuttle comes, drives the party and lets it out."""

import re

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.passenger import MOMENT, book, cancel
from tests.e2e.scripted_shuttle import ScriptedShuttle

pytestmark = [pytest.mark.browser, pytest.mark.real]

QUICK_MPS = 60.0


def test_a_ride_is_boarded_and_left_by_taps_that_open_when_the_shuttle_stands_there(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", **PHONE)
    shuttle.speed_mps = 0.0
    book(page, "Main Library", "Gymnasium")
    aboard = page.get_by_role("button", name="I’m on board")
    expect(aboard).to_be_disabled()
    shuttle.speed_mps = QUICK_MPS
    expect(aboard).to_be_enabled(timeout=90_000)
    expect(page.get_by_role("heading", name="Shuttle 1 is at your stop")).to_be_visible()
    aboard.click()
    off = page.get_by_role("button", name="I’m off")
    expect(off).to_be_enabled(timeout=90_000)
    expect(page.get_by_role("heading", name="You have arrived")).to_be_visible()
    off.click()
    expect(page.get_by_role("heading", name="Ride completed")).to_be_visible()


def test_a_kept_cancel_that_comes_after_boarding_lets_nobody_out(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", allowed=(409,), goes_offline=True, **PHONE)
    shuttle.speed_mps = 0.0
    book(page, "Main Library", "Gymnasium")
    link = page.url
    page.context.set_offline(True)
    page.get_by_role("button", name="Cancel the ride").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel the ride").click()
    expect(page.get_by_text("Not cancelled yet")).to_be_visible()
    other = open_page("/", **PHONE)
    other.goto(link)
    other.reload()
    shuttle.speed_mps = QUICK_MPS
    aboard = other.get_by_role("button", name="I’m on board")
    expect(aboard).to_be_enabled(timeout=90_000)
    shuttle.speed_mps = 0.5
    aboard.click()
    expect(other.get_by_role("button", name="Get off at the next stop")).to_be_visible()
    page.context.set_offline(False)
    expect(page.get_by_text("The ride was not cancelled.")).to_be_visible()
    expect(page.get_by_text("You are already on board.")).to_be_visible()
    expect(page.get_by_text("Not cancelled yet")).to_have_count(0)
    shuttle.speed_mps = QUICK_MPS
    off = other.get_by_role("button", name="I’m off")
    expect(off).to_be_enabled(timeout=90_000)
    off.click()
    expect(other.get_by_role("heading", name="Ride completed")).to_be_visible()


def test_another_destination_is_chosen_on_the_way_and_the_promise_told_anew(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", **PHONE)
    book(page, "Main Library", "Gymnasium")
    page.get_by_role("button", name="Change destination").click()
    page.get_by_role("searchbox").fill("Management")
    page.locator(".stop-choice", has_text="Management Building").first.click()
    expect(page.locator(".trip")).to_contain_text("Management Building")
    expect(page.locator(".trip")).to_contain_text(re.compile(rf"Arrival by {MOMENT}"))
    cancel(page)


def test_who_rides_can_get_off_early(open_page: OpenPage, shuttle: ScriptedShuttle) -> None:
    page = open_page("/", **PHONE)
    shuttle.speed_mps = QUICK_MPS
    book(page, "Main Library", "Gymnasium")
    aboard = page.get_by_role("button", name="I’m on board")
    expect(aboard).to_be_enabled(timeout=90_000)
    shuttle.speed_mps = 0.5
    aboard.click()
    page.get_by_role("button", name="Get off at the next stop").click()
    page.get_by_role("dialog").get_by_role("button", name="Get off at the next stop").click()
    expect(page.get_by_text("You get off at the stop below.")).to_be_visible()
    shuttle.speed_mps = QUICK_MPS
    off = page.get_by_role("button", name="I’m off")
    expect(off).to_be_enabled(timeout=90_000)
    off.click()
    expect(page.get_by_text("You got off before your stop.")).to_be_visible()
