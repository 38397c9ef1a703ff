"""Without a connection: the passenger page, the stops, the timetable and the ticket, and how old they are."""

import re

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.passenger import book, cancel

pytestmark = [pytest.mark.browser, pytest.mark.real, pytest.mark.usefixtures("shuttle")]

KEPT = {"service_workers": "allow"}
_CONTROLLED = "navigator.serviceWorker.ready.then(() => true)"


def kept_page(open_page: OpenPage) -> Page:
    """With the worker in charge, as on every visit but the first, and all that the page asks for loaded."""
    page = open_page("/", goes_offline=True, **PHONE, **KEPT)
    page.evaluate(_CONTROLLED)
    page.reload(wait_until="networkidle")
    expect(page.get_by_role("heading", name="Where to?")).to_be_visible()
    return page


def test_the_page_opens_without_a_connection_and_says_what_it_shows(open_page: OpenPage) -> None:
    page = kept_page(open_page)
    page.context.set_offline(True)
    page.reload()
    expect(page.get_by_role("heading", name="Where to?")).to_be_visible()
    expect(page.locator("[data-offline]")).to_contain_text(
        re.compile(r"no connection. This page shows what was known at \d\d:\d\d")
    )
    expect(page.locator(".stop-choice", has_text="Main Library")).to_be_visible()
    page.context.set_offline(False)
    expect(page.locator("[data-offline]")).to_have_count(0)


def test_a_ticket_is_there_without_a_connection(open_page: OpenPage) -> None:
    page = kept_page(open_page)
    code = book(page, "Main Library", "Gymnasium")
    boarding = page.locator("[data-boarding-code]").inner_text()
    page.context.set_offline(True)
    page.reload()
    expect(page.locator("[data-ride-code]")).to_have_text(code)
    expect(page.locator("[data-boarding-code]")).to_have_text(boarding)
    expect(page.locator("[data-offline]")).to_be_visible()
    page.context.set_offline(False)
    expect(page.locator("[data-offline]")).to_have_count(0)
    cancel(page)


def test_a_cancelled_ride_is_not_kept_as_it_was(open_page: OpenPage) -> None:
    page = kept_page(open_page)
    book(page, "Main Library", "Gymnasium")
    address = page.url
    cancel(page)
    page.wait_for_timeout(1000)
    page.context.set_offline(True)
    page.goto(address)
    page.reload()
    expect(page.get_by_role("heading", name="Ride cancelled")).to_be_visible()


def test_only_the_last_ticket_is_kept(open_page: OpenPage) -> None:
    page = kept_page(open_page)
    for _ in range(2):
        book(page, "Main Library", "Gymnasium")
        cancel(page)
        page.get_by_role("button", name="Book another ride").click()
    count = page.evaluate(
        "caches.open('campusloop-ticket-1').then((cache) => cache.keys()).then((keys) => keys.length)"
    )
    assert count == 1


def test_the_console_is_never_a_kept_one(open_page: OpenPage) -> None:
    page = kept_page(open_page)
    names = page.evaluate(
        "caches.keys().then((names) => Promise.all(names.map(async (name) =>"
        " (await (await caches.open(name)).keys()).map((request) => request.url))))"
    )
    assert not [url for urls in names for url in urls if "console" in url or "session" in url]
