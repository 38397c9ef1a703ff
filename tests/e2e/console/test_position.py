"""An operator names the place of a shuttle that stands: two clicks on the map, a confirmation, its answer."""

import math

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import OpenPage
from tests.e2e.operator import show_vehicle, sign_in
from tests.e2e.scripted_shuttle import ScriptedShuttle

pytestmark = pytest.mark.browser


@pytest.fixture
def console(open_page: OpenPage, shuttle: ScriptedShuttle) -> Page:
    page = open_page("/console", allowed=(409,))
    sign_in(page)
    return page


def test_a_place_is_clicked_its_direction_too_and_the_shuttles_answer_is_shown(
    console: Page, shuttle: ScriptedShuttle
) -> None:
    shuttle.speed_mps = 0.0
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_text("Name its place", exact=True).click()
    panel.get_by_role("button", name="Choose on the map").click()
    confirm = panel.get_by_role("button", name="It stands here")
    expect(confirm).to_be_disabled()
    canvas = console.locator("canvas").first
    box = canvas.bounding_box()
    assert box is not None
    middle = {"x": box["width"] / 2.0, "y": box["height"] / 2.0}
    canvas.click(position=middle)
    expect(panel).to_contain_text("Now click where its front points to.")
    expect(confirm).to_be_disabled()
    canvas.click(position={"x": middle["x"], "y": middle["y"] - 80.0})
    expect(panel).to_contain_text("Another click begins again.")
    confirm.click()
    expect(panel).to_contain_text("Its answer comes within 20 seconds")
    expect(panel).to_contain_text("scans agree, 1.2 m from the named place")
    assert shuttle.named is not None
    # Up on the map is north.
    assert abs(math.remainder(shuttle.named.yaw_rad - math.pi / 2.0, math.tau)) < 0.05
    expect(panel.get_by_role("button", name="Choose on the map")).to_be_visible()
    console.get_by_role("link", name="Audit log").click()
    expect(console.get_by_text("set_vehicle_position").first).to_be_visible()


def test_a_choice_that_is_given_up_sends_nothing(console: Page, shuttle: ScriptedShuttle) -> None:
    before = shuttle.named
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_text("Name its place", exact=True).click()
    panel.get_by_role("button", name="Choose on the map").click()
    canvas = console.locator("canvas").first
    canvas.click()
    expect(panel).to_contain_text("Now click where its front points to.")
    panel.get_by_role("button", name="Back").click()
    expect(panel.get_by_role("button", name="Choose on the map")).to_be_visible()
    canvas.click()
    expect(panel.get_by_role("button", name="It stands here")).to_have_count(0)
    assert shuttle.named is before
