"""Steps of a passenger on the page."""

import re

from playwright.sync_api import Page, expect

# A time of today, or with its date: at night an arrival lies in the next day.
MOMENT = r"(?:\w{3} \d{1,2} \w{3}, )?\d\d:\d\d"


def choose_stop(page: Page, end: str, name: str) -> None:
    """end: "From" or "To"."""
    page.get_by_role("button", name=re.compile(f"^{end}")).click()
    page.get_by_role("searchbox").fill(name)
    page.locator(".stop-choice", has_text=name).first.click()


def fill_booking(page: Page, origin: str, destination: str) -> None:
    choose_stop(page, "From", origin)
    choose_stop(page, "To", destination)


def book(page: Page, origin: str, destination: str) -> str:
    """The ride's code."""
    fill_booking(page, origin, destination)
    page.get_by_role("button", name="Book the ride").click()
    code = page.locator("[data-ride-code]")
    expect(code).to_be_visible()
    return code.inner_text()


def cancel(page: Page) -> None:
    page.get_by_role("button", name="Cancel the ride").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel the ride").click()
    expect(page.get_by_role("heading", name="Ride cancelled")).to_be_visible()
