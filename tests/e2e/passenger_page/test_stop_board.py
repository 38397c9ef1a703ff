"""A screen at a stop: what comes, how old it is, and the way to a booking from there."""

import re

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.operator import sign_in
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real]


def test_an_operator_finds_the_board_on_which_a_coming_shuttle_stands_and_a_code_to_book(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    shuttle.speed_mps = 0.0
    stops = {stop["name_en"]: stop["stop_id"] for stop in server.http.get("/stops").json()}
    wish = {"from_stop": stops["Yongfu Temple"], "to_stop": stops["Gymnasium"]}
    ride = server.change("POST", "/rides", wish)
    console = open_page("/console#/service")
    sign_in(console)
    link = console.get_by_role("link", name="Yongfu Temple")
    board = open_page(str(link.get_attribute("href")))
    expect(board.get_by_role("heading", name="Yongfu Temple")).to_be_visible()
    row = board.locator("[data-shuttle='Shuttle 1']")
    expect(row).to_contain_text(re.compile(r"\d min"))
    assert ride["ride_code"] not in board.content()
    code = board.get_by_role("img")
    expect(code).to_be_visible()
    assert code.evaluate("picture => picture.complete && picture.naturalWidth > 0")
    booking = open_page(str(code.get_attribute("alt")).removeprefix(server.origin), **PHONE)
    expect(booking.get_by_role("button", name=re.compile("^From"))).to_contain_text("Yongfu Temple")
    server.change("POST", f"/rides/{ride['token']}/cancel")
    expect(board.get_by_text("No shuttle is on its way to this stop.")).to_be_visible()


def test_a_board_without_a_connection_says_since_when_and_shows_no_minutes(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    shuttle.speed_mps = 0.0
    stop_id = server.http.get("/stops").json()[0]["stop_id"]
    page = open_page("/", goes_offline=True)
    page.clock.install()
    page.goto(f"{server.origin}/board/{stop_id}")
    expect(page.get_by_role("heading", name="Shuttles for booked rides")).to_be_visible()
    page.context.set_offline(True)
    page.clock.run_for(45_000)
    expect(page.get_by_role("alert")).to_contain_text(re.compile(r"No connection since \d\d:\d\d"))
    expect(page.get_by_role("heading", name="Shuttles for booked rides")).to_have_count(0)
    page.context.set_offline(False)
    page.clock.run_for(6_000)
    expect(page.get_by_role("alert")).to_have_count(0)


def test_a_board_of_no_stop_says_so(open_page: OpenPage) -> None:
    page = open_page("/board/nowhere", allowed=(404,))
    expect(page.get_by_role("heading")).to_contain_text("no stop “nowhere”")
