"""The past on the console: the whole fleet on one line of time, and links to a moment."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import OpenPage
from tests.e2e.operator import show_vehicle, sign_in
from tests.e2e.recorded_run import record_run, upload_run
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess

pytestmark = pytest.mark.browser


@pytest.fixture
def console(open_page: OpenPage, shuttle: ScriptedShuttle) -> Page:
    page = open_page("/console")
    sign_in(page)
    return page


def set_time(page: Page, share: float) -> None:
    page.get_by_label("Time in the run").evaluate(
        "(range, part) => { range.value = Number(range.min) + (range.max - range.min) * part;"
        " range.dispatchEvent(new Event('input', { bubbles: true })); }",
        share,
    )


def test_the_day_of_the_fleet_shows_what_was_done_and_where_everyone_was(console: Page) -> None:
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_role("button", name="Hold").click()
    console.get_by_role("dialog").get_by_role("button", name="Hold").click()
    expect(panel.get_by_role("button", name="Resume")).to_be_visible()
    panel.get_by_role("button", name="Resume").click()
    console.get_by_role("link", name="Runs").click()
    console.get_by_role("button", name="Replay the fleet").click()
    happened = console.get_by_role("region", name="What happened")
    expect(happened).to_contain_text("Shuttle 1: held (operator)")
    happened.get_by_role("button", name="held (operator)").last.click()
    fleet = console.get_by_role("region", name="Vehicles")
    expect(fleet.locator(".row", has_text="Shuttle 1")).not_to_contain_text("No connection")
    set_time(console, 0.0)
    expect(console.get_by_text("No shuttle reported a position at this time.")).to_be_visible()
    expect(fleet.locator(".row", has_text="Shuttle 1")).to_contain_text("No connection")


def test_a_link_leads_another_operator_to_the_same_second_and_shuttle(
    console: Page, open_page: OpenPage
) -> None:
    console.get_by_role("link", name="Runs").click()
    console.get_by_role("button", name="Replay the fleet").click()
    console.get_by_role("region", name="Vehicles").locator(".row", has_text="Shuttle 1").click()
    set_time(console, 0.5)
    half = console.locator(".timeline time").first.inner_text()
    link = console.get_by_role("link", name="Link to this moment").get_attribute("href")
    other = open_page(f"/console{link}")
    sign_in(other)
    expect(other.locator(".timeline time").first).to_have_text(half)
    expect(other.get_by_role("region", name="Shuttle 1")).to_be_visible()


def test_a_link_that_was_cut_off_says_so(console: Page) -> None:
    console.evaluate("location.hash = '#/runs/@fleet/17'")
    expect(console.get_by_text("This link to a replay is incomplete")).to_be_visible()
    expect(console.get_by_role("button", name="Replay the fleet")).to_be_visible()


def test_a_link_to_a_moment_of_a_run_and_its_events(
    console: Page, server: ServerProcess, shuttle: ScriptedShuttle, tmp_path: Path, open_page: OpenPage
) -> None:
    record_run(tmp_path / "0.mcap", "shuttle-1", "boot-7", server.network, seconds=30, brakes_at_s=12)
    upload_run(shuttle, tmp_path / "0.mcap", server.http)
    console.get_by_role("link", name="Runs").click()
    console.locator("a[href*='boot-7']").click()
    console.get_by_role("button", name="Go to the next event").click()
    expect(console.locator(".led")).to_contain_text("second 12")
    expect(console.get_by_role("region", name="What happened")).to_contain_text("brakes hard")
    expect(console.get_by_role("button", name="Go to the next event")).to_be_disabled()
    with console.expect_download() as download:
        console.get_by_role("link", name="Part 1").click()
    assert download.value.suggested_filename == "shuttle-1-boot-7-0000.mcap"
    assert Path(download.value.path()).read_bytes() == (tmp_path / "0.mcap").read_bytes()
    link = console.get_by_role("link", name="Link to this moment").get_attribute("href")
    other = open_page(f"/console{link}")
    sign_in(other)
    expect(other.locator(".led")).to_contain_text("second 12")


@pytest.mark.usefixtures("shuttle")
def test_a_past_that_did_not_come_is_asked_for_again(open_page: OpenPage) -> None:
    page = open_page("/console", allowed=(503,))
    sign_in(page)
    page.route("**/api/v1/replays/fleet*", lambda route: route.fulfill(status=503, json={}))
    page.get_by_role("link", name="Runs").click()
    page.get_by_role("button", name="Replay the fleet").click()
    retry = page.get_by_role("button", name="Try again")
    expect(retry).to_be_visible()
    page.unroute("**/api/v1/replays/fleet*")
    retry.click()
    expect(page.get_by_role("region", name="Vehicles")).to_contain_text("Shuttle 1")
    expect(retry).to_have_count(0)
