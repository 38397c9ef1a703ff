"""A browser without JavaScript books, follows and cancels a ride."""

import re

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.targets import small_targets, sticks_out

pytestmark = [pytest.mark.browser, pytest.mark.real, pytest.mark.usefixtures("shuttle")]


def test_a_ride_is_booked_and_cancelled(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE, java_script_enabled=False)
    page.get_by_role("link", name="Book a ride without JavaScript").click()
    page.get_by_label("From").select_option(label="Main Library")
    page.get_by_label("To").select_option(label="Gymnasium")
    page.get_by_label("When").select_option(label="In 15 minutes")
    page.get_by_role("button", name="Book the ride").click()
    expect(page.get_by_role("heading", name="Your ride is booked")).to_be_visible()
    expect(page.get_by_text(re.compile(r"Pickup between \d\d:\d\d and \d\d:\d\d"))).to_be_visible()
    expect(page.get_by_text("Shuttle 1", exact=True)).to_be_visible()
    page.get_by_role("button", name="Cancel the ride").click()
    expect(page.get_by_role("heading", name="Ride cancelled")).to_be_visible()


def test_the_form_fits_a_phone_and_speaks_chinese(open_page: OpenPage) -> None:
    page = open_page("/basic", **PHONE)
    page.get_by_role("link", name="中文").click()
    expect(page.get_by_role("heading", name="校园班车")).to_be_visible()
    assert not sticks_out(page)
    assert small_targets(page, 44) == []
