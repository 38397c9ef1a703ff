"""Roads are closed by clicking them, after the effects were shown, and the closure can be undone."""

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.campus_map import click_road
from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.operator import sign_in
from tests.e2e.passenger import book
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real]


@pytest.fixture
def service(open_page: OpenPage, shuttle: ScriptedShuttle) -> Page:
    page = open_page("/console")
    sign_in(page)
    page.get_by_role("link", name="Service").click()
    return page


def lane_of(server: ServerProcess, name: str) -> str:
    stops = server.network.road_map.stops
    return next(stop.lane_id for stop in stops if stop.name_en == name)


def test_a_road_is_clicked_its_closing_previewed_made_and_undone(
    service: Page, open_page: OpenPage, server: ServerProcess
) -> None:
    phone = open_page("/", **PHONE)
    code = book(phone, "Main Library", "Gymnasium")
    canvas = service.get_by_role("application", name="choose the roads")
    ask = service.get_by_role("button", name="Show what this does")
    expect(ask).to_be_disabled()
    click_road(canvas, server.network, lane_of(server, "Gymnasium"))
    expect(service.locator(".chosen-roads li")).to_have_count(1)
    click_road(canvas, server.network, lane_of(server, "Gymnasium"))
    expect(service.locator(".chosen-roads li")).to_have_count(0)
    click_road(canvas, server.network, lane_of(server, "Gymnasium"))
    ask.click()
    question = service.get_by_role("dialog")
    expect(question.locator(f'[data-effect="{code}"]')).to_contain_text("the ride ends")
    question.get_by_role("button", name="Back").click()
    expect(service.locator("[data-closure]")).to_have_count(0)
    expect(phone.get_by_role("button", name="Cancel the ride")).to_be_visible()
    ask.click()
    question.get_by_role("button", name="Close the road").click()
    expect(service.get_by_text("The road is closed.")).to_be_visible()
    expect(service.locator("[data-closure]")).not_to_contain_text(lane_of(server, "Gymnasium"))
    expect(phone.get_by_role("heading", name="This ride could not be finished")).to_be_visible()
    service.get_by_role("button", name="Undo").click()
    expect(service.locator("[data-closure]")).to_have_count(0)
    assert server.http.get("/closures").json() == []


def test_the_keyboard_chooses_the_road_at_the_centre_of_the_map(service: Page) -> None:
    canvas = service.get_by_role("application", name="choose the roads")
    canvas.focus()
    chosen = service.locator(".chosen-roads li")
    for _ in range(60):
        canvas.press("Enter")
        if chosen.count():
            break
        canvas.press("ArrowLeft")
    expect(chosen.first).to_be_visible()
    service.get_by_role("button", name="Deselect").first.click()
    expect(chosen).to_have_count(0)
