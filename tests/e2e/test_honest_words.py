"""What people read is true of their ride, and in words: no ids, no codes, nothing that does not exist."""

import re
from datetime import UTC, datetime, timedelta

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.operator import sign_in
from tests.e2e.passenger import book, fill_booking
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real]

QUICK_MPS = 60.0
RAW = re.compile(r"\b[a-z]+_[a-z_]+\b|\bride-[0-9a-f]|\bshuttle-\d")


def booked_by_api(server: ServerProcess, **changes: object) -> str:
    """The token of a ride from the Main Library to the Gymnasium."""
    stops = {stop.name_en: stop.stop_id for stop in server.network.road_map.stops}
    ends = {"from_stop": stops["Main Library"], "to_stop": stops["Gymnasium"]}
    token: str = server.change("POST", "/rides", ends | changes)["token"]
    return token


@pytest.mark.usefixtures("shuttle")
def test_no_more_wheelchairs_can_be_chosen_than_a_shuttle_has_places(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    fill_booking(page, "Main Library", "Gymnasium")
    page.get_by_role("group", name="People").get_by_role("button", name="One more").click()
    wheelchairs = page.get_by_role("group", name="Wheelchairs")
    wheelchairs.get_by_role("button", name="One more").click()
    expect(wheelchairs.get_by_role("button", name="One more")).to_be_disabled()
    expect(page.get_by_text("Each shuttle has 1 wheelchair place.")).to_be_visible()


@pytest.mark.usefixtures("shuttle")
def test_a_refusal_for_wheelchairs_names_no_time_that_would_not_help(
    open_page: OpenPage, server: ServerProcess
) -> None:
    page = open_page(f"/#ride={booked_by_api(server, party=2, wheelchairs=2)}", **PHONE)
    expect(page.get_by_role("heading", name="No shuttle can take this ride")).to_be_visible()
    expect(page.get_by_text("Each shuttle has 1 wheelchair place.")).to_be_visible()
    expect(page.locator("main")).not_to_contain_text("later")


@pytest.mark.usefixtures("shuttle")
def test_a_ride_for_tomorrow_is_booked_and_not_on_its_way(open_page: OpenPage, server: ServerProcess) -> None:
    tomorrow = (datetime.now(UTC) + timedelta(days=1)).isoformat()
    token = booked_by_api(server, earliest=tomorrow)
    page = open_page(f"/#ride={token}", **PHONE)
    expect(page.get_by_role("heading", name="Your ride is booked for")).to_be_visible()
    expect(page.get_by_role("status").first).to_have_text("Your ride is booked")
    expect(page.locator("main")).not_to_contain_text("on its way")
    expect(page.get_by_role("button", name="I’m on board")).to_have_count(0)
    server.change("POST", f"/rides/{token}/cancel")


def test_who_missed_the_shuttle_reads_that_and_no_code_of_it(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", **PHONE)
    shuttle.speed_mps = QUICK_MPS
    code = book(page, "Main Library", "Gymnasium")
    missed = page.get_by_role("heading", name="The shuttle left without you")
    expect(missed).to_be_visible(timeout=150_000)
    expect(page.locator("[data-boarding-code]")).to_have_count(0)
    expect(page.locator("main")).not_to_contain_text("later than")
    console = open_page("/console")
    sign_in(console)
    console.get_by_role("link", name="Rides").click()
    console.get_by_role("button", name="All", exact=True).click()
    row = console.locator(f'[data-ride="{code}"]')
    expect(row).to_contain_text("No show")
    expect(row).to_contain_text("Shuttle 1")
    assert RAW.search(row.inner_text()) is None, row.inner_text()


def test_an_incident_says_what_happened_and_what_to_do(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    console = open_page("/console")
    sign_in(console)
    shuttle.stop_with_fault("gate_braking_steering_stuck")
    console.get_by_role("link", name="Incidents").click()
    card = console.locator("[data-kind=minimal_risk_stop]")
    expect(card).to_contain_text("gate brakes: steering does not follow")
    expect(card).to_contain_text("Check that the way is clear")
    expect(card).to_contain_text("Shuttle 1")
    assert RAW.search(card.inner_text()) is None, card.inner_text()
    console.get_by_role("button", name="中文").click()
    expect(card).to_contain_text("请确认道路畅通")
    assert RAW.search(card.inner_text()) is None, card.inner_text()
    console.get_by_role("button", name="EN").click()
    server.change("POST", f"/vehicles/{shuttle.vehicle_id}/resume")
    expect(card).to_have_count(0)
