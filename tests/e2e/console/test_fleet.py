"""A large fleet on the console: searched, filtered, in natural order, and quick."""

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from benchmarks.web.console_frames import fleet_script, measure_console
from tests.e2e.conftest import WITHIN_MS
from tests.e2e.operator import sign_in
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real]

FLEET = 1000
NODES_MAX = 1000


@pytest.fixture
def fleet(browser: Browser, server: ServerProcess) -> Iterator[Page]:
    context = browser.new_context(locale="en-GB", viewport={"width": 1440, "height": 900})
    context.set_default_timeout(WITHIN_MS)
    context.add_init_script(fleet_script(FLEET))
    page = context.new_page()
    page.goto(f"{server.origin}/console")
    sign_in(page)
    expect(page.locator(".row").first).to_be_visible(timeout=240_000)
    yield page
    context.close()


def names(page: Page) -> list[str]:
    return page.locator(".row strong").all_inner_texts()


def test_the_list_counts_as_people_do_and_has_only_the_rows_on_the_screen(fleet: Page) -> None:
    assert names(fleet)[:11] == [f"Shuttle {number}" for number in range(1, 12)]
    assert fleet.evaluate("document.getElementsByTagName('*').length") < NODES_MAX
    fleet.locator(".side").evaluate("(side) => side.scrollTo(0, side.scrollHeight)")
    expect(fleet.locator(".row", has_text=re.compile(f"Shuttle {FLEET}"))).to_be_visible()
    assert fleet.locator(".row").count() < 60


def test_a_shuttle_is_found_by_name_and_by_state(fleet: Page) -> None:
    fleet.get_by_label("Search").fill("shuttle 777")
    expect(fleet.locator(".row strong")).to_have_text(["Shuttle 777"])
    expect(fleet.get_by_text(f"1 of {FLEET} vehicles")).to_be_visible()
    fleet.get_by_label("Search").fill("")
    fleet.get_by_label("State").select_option(label="Held, manual or blocked")
    expect(fleet.get_by_text(f"59 of {FLEET} vehicles")).to_be_visible()
    assert names(fleet)[:3] == ["Shuttle 1", "Shuttle 18", "Shuttle 35"]
    fleet.locator(".row", has_text="Shuttle 18").first.click()
    expect(fleet.get_by_role("region", name="Shuttle 18")).to_be_visible()


def test_a_thousand_vehicles_move_on_one_canvas(browser: Browser, server: ServerProcess) -> None:
    """How smoothly is measured by `benchmarks.web`: a slow machine is no failure."""
    seen = measure_console(browser, server, FLEET, 4.0, None)
    assert (seen.vehicles, seen.nodes < NODES_MAX) == (FLEET, True)
    assert seen.fps_median >= 1.0
