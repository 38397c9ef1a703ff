"""Text follows the size that the reader has set, and everything to be tapped is large enough."""

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.operator import show_vehicle, sign_in
from tests.e2e.passenger import cancel, fill_booking
from tests.e2e.server_process import ServerProcess
from tests.e2e.targets import small_targets, sticks_out

pytestmark = [pytest.mark.browser, pytest.mark.real]

PASSENGER_PX, CONSOLE_PX = 48, 44


def enlarge(page: Page) -> None:
    """What a reader's setting of the browser does: it doubles the size that rem counts in."""
    page.add_style_tag(content="html { font-size: 200% }")


@pytest.mark.usefixtures("shuttle")
def test_everything_on_the_passenger_page_can_be_tapped_with_a_thumb(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    fill_booking(page, "Main Library", "Gymnasium")
    assert small_targets(page, PASSENGER_PX) == []
    page.get_by_role("button", name="Later").click()
    assert small_targets(page, PASSENGER_PX) == []
    page.get_by_role("button", name="Repeat").click()
    assert small_targets(page, PASSENGER_PX) == []
    page.get_by_role("button", name="Now").click()
    page.get_by_role("button", name="Book the ride").click()
    expect(page.locator("[data-ride-code]")).to_be_visible()
    assert small_targets(page, PASSENGER_PX) == []
    page.get_by_role("button", name="Help").click()
    expect(page.get_by_role("dialog")).to_be_visible()
    assert small_targets(page, PASSENGER_PX) == []
    page.get_by_role("button", name="Not now").click()
    cancel(page)
    page.goto(f"{page.url.split('#')[0]}#code=")
    expect(page.get_by_label("Ride code")).to_be_visible()
    assert small_targets(page, PASSENGER_PX) == []


@pytest.mark.usefixtures("shuttle")
@pytest.mark.parametrize(
    "place", ["live", "live/shuttle-1", "rides", "service", "incidents", "runs", "access"]
)
def test_everything_on_the_console_can_be_hit(open_page: OpenPage, server: ServerProcess, place: str) -> None:
    page = open_page("/console")
    sign_in(page)
    expect(page.locator(".console")).to_be_visible()
    page.goto(f"{server.origin}/console#/{place}")
    expect(page.locator("main h1, main h2, main canvas").first).to_be_visible()
    assert small_targets(page, CONSOLE_PX) == []


@pytest.mark.usefixtures("shuttle")
def test_text_follows_the_readers_size_and_the_layout_holds(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    before = page.locator("h1").evaluate("(title) => parseFloat(getComputedStyle(title).fontSize)")
    enlarge(page)
    after = page.locator("h1").evaluate("(title) => parseFloat(getComputedStyle(title).fontSize)")
    assert after == pytest.approx(2 * before)
    fill_booking(page, "Main Library", "Gymnasium")
    assert not sticks_out(page)
    page.get_by_role("button", name="Repeat").click()
    assert not sticks_out(page)
    page.get_by_role("button", name="Now").click()
    page.get_by_role("button", name="Book the ride").click()
    expect(page.locator("[data-ride-code]")).to_be_visible()
    assert not sticks_out(page)
    cancel(page)


@pytest.mark.usefixtures("shuttle")
@pytest.mark.parametrize("place", ["live", "rides", "service", "incidents", "runs", "access"])
def test_the_console_holds_at_twice_the_size_of_text(
    open_page: OpenPage, server: ServerProcess, place: str
) -> None:
    page = open_page("/console")
    sign_in(page)
    expect(page.locator(".console")).to_be_visible()
    page.goto(f"{server.origin}/console#/{place}")
    enlarge(page)
    expect(page.locator("main h1, main h2, main canvas").first).to_be_visible()
    assert not sticks_out(page)
    if place == "live":
        panel = show_vehicle(page, "Shuttle 1")
        expect(panel.get_by_role("button", name="Hold")).to_be_visible()
        assert not sticks_out(page)
