"""The first booking in three taps, the next one in one, and what links and printed codes fill in."""

import re
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.passenger import book, cancel
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real]


def stop_ids(server: ServerProcess) -> dict[str, str]:
    return {stop.name_en: stop.stop_id for stop in server.network.road_map.stops}


@pytest.mark.usefixtures("shuttle")
def test_three_taps_book_a_ride(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    page.locator(".stop-choice", has_text="Main Library").tap()
    page.locator(".stop-choice", has_text="Gymnasium").tap()
    page.get_by_role("button", name="Book the ride").tap()
    expect(page.locator("[data-ride-code]")).to_be_visible()
    cancel(page)


@pytest.mark.usefixtures("shuttle")
def test_what_was_booked_before_is_booked_again_by_one_tap(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    book(page, "Main Library", "Gymnasium")
    cancel(page)
    page.get_by_role("button", name="Book another ride").click()
    page.reload()
    page.get_by_role("button", name="Main Library to Gymnasium, now").tap()
    expect(page.locator("[data-ride-code]")).to_be_visible()
    expect(page.locator(".trip")).to_contain_text("Gymnasium")
    cancel(page)


@pytest.mark.usefixtures("shuttle")
def test_a_printed_code_fills_in_the_stop_where_it_hangs(open_page: OpenPage, server: ServerProcess) -> None:
    page = open_page(f"/?from={stop_ids(server)['Main Library']}", **PHONE)
    expect(page.get_by_role("button", name="From Main Library")).to_be_visible()
    expect(page.get_by_role("heading", name="Choose a destination")).to_be_visible()
    old = open_page("/?from=stop-that-moved", **PHONE)
    expect(old.get_by_text("The stop of this link is no longer on the map.")).to_be_visible()


def test_the_nearest_stop_is_found_by_the_phone(open_page: OpenPage, server: ServerProcess) -> None:
    view = server.http.get("/campus").json()["origin"]
    place = {"latitude": view["latitude_deg"], "longitude": view["longitude_deg"]}
    page = open_page("/", **PHONE, geolocation=place, permissions=["geolocation"])
    page.get_by_role("button", name="Use the nearest stop").tap()
    stops = server.http.get("/stops").json()
    nearest = min(stops, key=lambda stop: stop["x_m"] ** 2 + stop["y_m"] ** 2)
    expect(page.get_by_role("button", name=f"From {nearest['name_en']}")).to_be_visible()
    away = open_page("/", **PHONE, geolocation={"latitude": 0, "longitude": 0}, permissions=["geolocation"])
    away.get_by_role("button", name="Use the nearest stop").tap()
    expect(away.get_by_text("You are far from the campus.")).to_be_visible()


@pytest.mark.usefixtures("shuttle")
def test_later_is_mostly_a_quarter_or_half_an_hour(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    page.get_by_role("button", name="Later").click()
    field = page.get_by_label("Earliest pickup, campus time")
    page.get_by_role("button", name="in 60 min").click()
    later = field.input_value()
    page.get_by_role("button", name="in 15 min").click()
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d", later)
    assert field.input_value() < later


@pytest.mark.parametrize("hours", [-1, 1])
@pytest.mark.usefixtures("shuttle")
def test_a_phone_whose_clock_is_an_hour_off_books_for_the_time_that_it_shows(
    open_page: OpenPage, server: ServerProcess, hours: int
) -> None:
    page = open_page("/", **PHONE)
    page.clock.install(time=datetime.now(UTC) + timedelta(hours=hours))
    page.reload()
    page.get_by_role("button", name="Main Library").tap()
    page.get_by_role("button", name="Gymnasium").tap()
    page.get_by_role("button", name="Later").click()
    page.get_by_role("button", name="in 30 min").click()
    timezone = ZoneInfo(server.http.get("/campus").json()["timezone"])
    entered = datetime.fromisoformat(page.get_by_label("Earliest pickup, campus time").input_value())
    wanted = datetime.now(timezone) + timedelta(minutes=30)
    assert abs(entered.replace(tzinfo=timezone) - wanted) < timedelta(minutes=2)
    page.get_by_role("button", name="Book the ride").tap()
    expect(page.locator("[data-ride-code]")).to_be_visible()
    cancel(page)
