"""Figures of the service on the console."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import OpenPage
from tests.e2e.operator import sign_in
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess

pytestmark = pytest.mark.browser


@pytest.fixture
def statistics(open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle) -> Page:
    stops = [stop.stop_id for stop in server.network.road_map.stops]
    server.change("POST", "/rides", {"from_stop": stops[0], "to_stop": stops[3], "party": 1})
    page = open_page("/console")
    sign_in(page)
    page.get_by_role("link", name="Statistics").click()
    return page


def test_a_ride_is_counted_in_its_hour_and_taken_along_as_a_table(statistics: Page) -> None:
    demand = statistics.get_by_role("region", name="Demand and service")
    expect(demand).to_contain_text("Rides wanted")
    expect(demand.get_by_role("img", name="Rides by the hour of the day")).to_be_visible()
    demand.get_by_text("Busiest ways: the numbers").click()
    with statistics.expect_download() as download:
        demand.get_by_role("link", name="Download as CSV").last.click()
    lines = Path(download.value.path()).read_text().splitlines()
    assert lines[0] == "From,To,Rides"
    assert len(lines) >= 2


def test_a_day_long_ago_says_that_nothing_was_wanted_or_driven(statistics: Page) -> None:
    statistics.get_by_label("Last day").fill("2024-02-29")
    expect(statistics.get_by_text("No rides were wanted in this time.")).to_be_visible()
    expect(statistics.get_by_text("No shuttle drove on this day.")).to_be_visible()


def test_figures_that_did_not_come_are_asked_for_again(open_page: OpenPage) -> None:
    page = open_page("/console", allowed=(503,))
    sign_in(page)
    page.get_by_role("link", name="Statistics").click()
    page.get_by_label("Last day").fill("2024-02-29")
    expect(page.get_by_text("No rides were wanted in this time.")).to_be_visible()
    page.route("**/api/v1/statistics/**", lambda route: route.fulfill(status=503, json={}))
    page.get_by_label("Show", exact=True).select_option("28")
    retry = page.get_by_role("button", name="Try again")
    expect(retry).to_have_count(2)
    page.unroute("**/api/v1/statistics/**")
    retry.first.click()
    expect(page.get_by_text("No rides were wanted in this time.")).to_be_visible()
    expect(page.get_by_label("Last day")).to_have_value("2024-02-29")
    expect(retry).to_have_count(0)
