"""The screen on board, served by the vehicle agent: what it shows and passes on, on small screens too."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from playwright.sync_api import Browser, Page, expect

from benchmarks.web.accessibility import AXE
from contract.geometry import Pose2
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from contract.wire.messages import DrivingView, HelpRequested, SeatButtonPressed, TrackReport
from tests.e2e.onboard_screen import OnboardScreen
from tests.e2e.server_process import CAMPUS_MAP
from tests.e2e.targets import small_targets
from tests.vehicle_agent.onboard.cabin_views import a_cabin_view, a_cabin_visit, a_status
from vehicle_agent.mission.memory import StandingAnnouncement
from vehicle_agent.onboard.cabin_view import CabinView
from vehicle_agent.signals import CodeTyped, DestinationChoice, HelpButton, SeatButton

pytestmark = [pytest.mark.browser, pytest.mark.real]

SCREENS = ((1280, 800), (800, 480))
_OVERFLOWS = """() => {
  const all = [document.documentElement, ...document.querySelectorAll("main > *, header, footer, dialog")];
  return all
    .filter((e) => e.scrollHeight > e.clientHeight + 1 || e.scrollWidth > e.clientWidth + 1)
    .map((e) => `${e.className || e.tagName} ${e.scrollWidth}x${e.scrollHeight}`);
}"""


def a_drive() -> CabinView:
    """On a road of the campus, between two people, with three stops ahead."""
    network = RoadNetwork(load_map(CAMPUS_MAP))
    lane_id = max(network.lines, key=lambda name: network.lines[name].length_m)
    x, y, yaw = (float(value) for value in network.pose(lane_id, 20.0))
    path = tuple(float(value) for s_m in range(20, 50, 5) for value in network.pose(lane_id, s_m)[:2])
    person = TrackReport(1, "pedestrian", path[4], path[5], 0.0, 0.6, 0.6, True, ())
    other = TrackReport(2, "pedestrian", x + 6.0, y + 6.0, 0.0, 0.6, 0.6, False, ())
    status = a_status(pose_map=Pose2(x, y, yaw), driving=DrivingView("yielding", path, (person, other)))
    visits = (
        a_cabin_visit(1, "Library", "图书馆", boarding=2),
        a_cabin_visit(2, "Science Building East Entrance", "理学楼东门"),
        a_cabin_visit(3, "Stadium", "体育馆", boarding=1),
        a_cabin_visit(4, "North Gate", "北门"),
    )
    return a_cabin_view(status=status, visits=visits, aboard=3, parties=2)


@pytest.fixture
def screen(tmp_path: Path) -> Iterator[OnboardScreen]:
    with OnboardScreen(tmp_path) as running:
        running.view = a_drive()
        yield running


@pytest.fixture
def open_screen(browser: Browser, screen: OnboardScreen) -> Iterator[Any]:
    contexts = []
    complaints: list[str] = []

    def opened(width: int = 1280, height: int = 800, **options: Any) -> Page:
        usual: dict[str, Any] = {"locale": "en-GB", "viewport": {"width": width, "height": height}}
        context = browser.new_context(**(usual | options))
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(screen.url)
        page.locator("canvas").wait_for()
        expect(page.locator("h1")).not_to_contain_text("unknown")
        return page

    yield opened
    for context in contexts:
        context.close()
    assert complaints == []


def violations(page: Page) -> list[str]:
    page.evaluate(AXE.read_text())
    found = page.evaluate("axe.run()")
    return [f"{one['id']}: {one['nodes'][0]['html'][:160]}" for one in found["violations"]]


def test_it_shows_where_the_shuttle_goes_what_it_sees_and_why_it_slows(open_screen: Any) -> None:
    page = open_screen()
    expect(page.locator("h1")).to_contain_text("Driving")
    expect(page.locator(".next")).to_have_text("Library")
    expect(page.locator(".when")).to_have_text("2 min or more")
    expect(page.locator(".stops li").first).to_contain_text("Science Building East Entrance")
    expect(page.locator(".facts")).to_contain_text("9 km/h")
    expect(page.locator(".facts")).to_contain_text("people, whom it lets pass")
    expect(page.locator(".facts")).to_contain_text("2, yields to 1")
    expect(page.get_by_text("Operators connected")).to_be_visible()


def test_an_announcement_of_the_operators_stays_below_what_is_said_until_it_ends(
    open_screen: Any, screen: OnboardScreen
) -> None:
    page = open_screen()
    expect(page.get_by_text("Operators connected")).to_be_visible()
    shown = StandingAnnouncement("Board at the east side", "在东侧上车", 2**62)
    screen.view = msgspec.structs.replace(a_drive(), shown=shown)
    expect(page.locator(".standing")).to_have_text("Board at the east side")
    screen.say_once(msgspec.structs.replace(screen.view, announce="Next stop: Library."))
    expect(page.locator(".said")).to_have_text("Next stop: Library.")
    expect(page.locator(".standing")).to_be_visible()
    page.get_by_role("button", name="中文").click()
    expect(page.locator(".standing")).to_have_text("在东侧上车")
    screen.view = a_drive()
    expect(page.locator(".standing")).to_have_count(0)


def test_a_seat_button_an_announcement_and_its_answer(open_screen: Any, screen: OnboardScreen) -> None:
    page = open_screen()
    page.get_by_role("button", name="Get off early").click()
    page.get_by_role("button", name="Seat 2").click()
    (pressed,) = screen.touched()
    assert isinstance(pressed, SeatButton)
    assert pressed.seat == 2
    refusal = SeatButtonPressed(2, False, "v1", "", 0.0, "no place")
    screen.say_once(msgspec.structs.replace(a_drive(), answers=(refusal,), announce="Next stop: Library."))
    expect(page.locator(".answer")).to_have_text("The shuttle cannot stop before its next stop.")
    expect(page.locator(".said")).to_have_text("Next stop: Library.")


def test_a_code_by_keyboard_and_a_destination_with_the_code_of_its_party(
    open_screen: Any, screen: OnboardScreen
) -> None:
    page = open_screen()
    page.get_by_role("button", name="Enter code").press("Enter")
    page.keyboard.type("1299")
    page.keyboard.press("Backspace")
    page.get_by_role("button", name="OK").click()
    (typed,) = screen.touched()
    assert isinstance(typed, CodeTyped)
    assert typed.code == "129"
    page.get_by_role("button", name="Change destination").click()
    page.get_by_role("button", name="More").click()
    page.locator(".stop-grid button").first.click()
    page.keyboard.type("4711")
    page.get_by_role("button", name="OK").click()
    (chosen,) = screen.touched()
    assert isinstance(chosen, DestinationChoice)
    assert (chosen.code, chosen.stop_id != "") == ("4711", True)


def test_the_only_party_aboard_is_asked_for_no_code(open_screen: Any, screen: OnboardScreen) -> None:
    screen.view = msgspec.structs.replace(a_drive(), parties=1)
    page = open_screen()
    page.get_by_role("button", name="Change destination").click()
    page.locator(".stop-grid button").first.click()
    (chosen,) = screen.touched()
    assert isinstance(chosen, DestinationChoice)
    assert chosen.code == ""


def test_a_call_for_help_says_whether_it_can_go_out(open_screen: Any, screen: OnboardScreen) -> None:
    screen.view = msgspec.structs.replace(a_drive(), connected=False)
    page = open_screen()
    expect(page.get_by_text("No connection to the operators. The shuttle drives on.")).to_be_visible()
    page.get_by_role("button", name="Help").click()
    page.get_by_role("button", name="Call for help").click()
    (call,) = screen.touched()
    assert isinstance(call, HelpButton)
    screen.say_once(msgspec.structs.replace(screen.view, answers=(HelpRequested(0),)))
    expect(page.locator(".answer")).to_have_text("Help is called.")
    page.wait_for_timeout(12_500)
    expect(page.locator(".answer")).to_contain_text("The call goes out when the connection is back")


def test_what_the_vehicle_does_not_know_is_unknown(open_screen: Any, screen: OnboardScreen) -> None:
    page = open_screen()
    unplaced = tuple(
        msgspec.structs.replace(visit, distance_m=None, least_s=None) for visit in a_drive().visits
    )
    screen.view = msgspec.structs.replace(a_drive(), has_position=False, visits=unplaced, connected=None)
    expect(page.locator(".when")).to_have_text("unknown")
    expect(page.get_by_text("Position unknown")).to_be_visible()
    expect(page.get_by_text("Connection to the operators: unknown")).to_be_visible()
    # The tick has ended: what it said last is no longer shown as true.
    screen.view = None
    expect(page.locator("h1")).to_contain_text("State unknown")
    expect(page.locator(".next")).to_have_text("unknown")
    screen.view = a_drive()
    expect(page.locator(".next")).to_have_text("Library")


@pytest.mark.parametrize(("width", "height"), SCREENS)
@pytest.mark.parametrize(("locale", "scheme"), [("en-GB", "light"), ("zh-CN", "dark")])
def test_every_state_fits_its_screen_is_large_enough_to_touch_and_accessible(
    open_screen: Any, width: int, height: int, locale: str, scheme: str, screenshots: Path | None
) -> None:
    page = open_screen(width, height, locale=locale, color_scheme=scheme)

    def look(state: str) -> None:
        page.wait_for_timeout(300)
        if screenshots is not None:
            page.screenshot(path=screenshots / f"onboard-{state}-{width}-{locale}.png")
        assert page.evaluate(_OVERFLOWS) == [], state
        assert small_targets(page, 48) == [], state
        assert violations(page) == [], state

    look("driving")
    for number, state in enumerate(("seats", "destination", "code", "help")):
        page.locator(".actions > button").nth(number).click()
        page.get_by_role("dialog").wait_for()
        look(state)
        page.keyboard.press("Escape")
        page.get_by_role("dialog").wait_for(state="detached")
