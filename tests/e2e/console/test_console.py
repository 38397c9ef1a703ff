import time
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import PHONE, WITHIN_MS, OpenPage
from tests.e2e.operator import show_vehicle, sign_in
from tests.e2e.passenger import book, cancel
from tests.e2e.recorded_run import record_run, upload_run
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess
from tests.e2e.targets import sticks_out

pytestmark = [pytest.mark.browser, pytest.mark.real]


@pytest.fixture
def console(open_page: OpenPage, shuttle: ScriptedShuttle) -> Page:
    return signed_in(open_page("/console"))


def signed_in(page: Page) -> Page:
    sign_in(page)
    expect(page.get_by_text("Connected")).to_be_visible()
    return page


def test_a_wrong_password_is_said_in_words(open_page: OpenPage) -> None:
    page = open_page("/console", allowed=(401,))
    sign_in(page, "not the password")
    expect(page.get_by_role("alert")).to_have_text("The name or the password is wrong.")


def test_a_session_survives_a_reload_and_ends_with_signing_out(console: Page) -> None:
    console.reload()
    expect(console.get_by_text("Connected")).to_be_visible()
    console.get_by_role("button", name="Sign out").click()
    expect(console.get_by_role("button", name="Sign in")).to_be_visible()


def test_a_vehicle_is_held_and_resumed(console: Page) -> None:
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_role("button", name="Hold").click()
    question = console.get_by_role("dialog")
    expect(question).to_contain_text("What this does")
    question.get_by_role("button", name="Hold").click()
    expect(panel.locator(".chip").first).to_have_text("Held")
    panel.get_by_role("button", name="Resume").click()
    expect(panel.locator(".chip").first).not_to_have_text("Held")


def test_a_shuttle_that_stands_before_something_is_waved_on(console: Page, shuttle: ScriptedShuttle) -> None:
    panel = show_vehicle(console, "Shuttle 1")
    shuttle.speed_mps, shuttle.obstacle_m = 0.0, 1.2
    expect(panel.locator(".chip").first).to_have_text("Blocked")
    shuttle.commanded.clear()
    panel.get_by_role("button", name="Resume").click()
    question = console.get_by_role("dialog")
    expect(question).to_contain_text("This shuttle has no cameras that it records.")
    assert "resume" not in shuttle.commanded
    question.get_by_role("button", name="Resume").click()
    expect(panel.get_by_text("Resume: sent to the shuttle.")).to_be_visible()
    deadline_s = time.monotonic() + 1e-3 * WITHIN_MS
    while "resume" not in shuttle.commanded and time.monotonic() < deadline_s:
        console.wait_for_timeout(100)
    assert shuttle.commanded == ["show_camera", "resume"]


@pytest.mark.usefixtures("shuttle")
def test_what_was_true_is_not_shown_as_live(open_page: OpenPage, shuttle: ScriptedShuttle) -> None:
    console = signed_in(open_page("/console", goes_offline=True))
    row = console.locator(".row", has_text="Shuttle 1")
    expect(row).to_contain_text("km/h")
    console.context.set_offline(True)
    expect(console.locator(".live[data-stale]")).to_be_visible()
    expect(row).to_contain_text("Unknown")
    expect(row).not_to_contain_text("km/h")
    expect(console.get_by_text("What you see is old")).to_be_visible()
    console.context.set_offline(False)
    expect(console.locator(".live[data-stale]")).to_have_count(0)
    expect(row).to_contain_text("km/h")


def test_a_recall_says_whom_it_leaves_behind_before_it_is_done(console: Page, open_page: OpenPage) -> None:
    phone = open_page("/", **PHONE)
    code = book(phone, "Main Library", "Gymnasium")
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_role("button", name="Recall").click()
    effect = console.get_by_role("dialog").locator(f'[data-effect="{code}"]')
    expect(effect).to_contain_text("left without a shuttle")
    console.get_by_role("dialog").get_by_role("button", name="Back").click()
    panel.get_by_role("button", name="Reassign").click()
    question = console.get_by_role("dialog")
    expect(question.get_by_label("Which rides")).to_contain_text(code)
    expect(question).to_contain_text("No ride changes.")
    question.get_by_role("button", name="Back").click()
    expect(panel.get_by_role("button", name="Recall")).to_be_visible()
    cancel(phone)


def test_an_announcement_appears_as_spoken_on_board(console: Page) -> None:
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_label("Text to say and show on board").fill("We wait for a delivery van.")
    panel.get_by_role("button", name="Announce").click()
    expect(panel.locator(".spoken")).to_contain_text("We wait for a delivery van.")


def test_a_call_for_help_goes_to_the_top_until_it_is_closed(console: Page, open_page: OpenPage) -> None:
    phone = open_page("/", **PHONE)
    code = book(phone, "Main Library", "Gymnasium")
    phone.get_by_role("button", name="Help").click()
    phone.get_by_label("What happened?").fill("The door does not open.")
    phone.get_by_role("button", name="Call for help").click()
    expect(phone.get_by_text("Help call received at")).to_be_visible()
    expect(console.get_by_role("alert")).to_contain_text("A passenger calls for help")
    console.get_by_role("link", name="Incidents").click()
    top = console.locator(".incident").first
    expect(top).to_have_attribute("data-kind", "help_call")
    expect(top.get_by_role("heading", level=2)).to_have_count(1)
    expect(top).to_contain_text("The door does not open.")
    expect(top).to_contain_text(code)
    top.get_by_role("button", name="Acknowledge").click()
    expect(top).to_contain_text("Seen by operator")
    top.get_by_role("button", name="Close").click()
    expect(console.locator("[data-kind=help_call]")).to_have_count(0)
    cancel(phone)


def test_a_ride_appears_and_is_cancelled_by_the_operator(console: Page, open_page: OpenPage) -> None:
    phone = open_page("/", **PHONE)
    code = book(phone, "Main Library", "Gymnasium")
    console.get_by_role("link", name="Rides").click()
    row = console.locator(f'[data-ride="{code}"]')
    expect(row).to_contain_text("Assigned")
    expect(row).to_contain_text("Main Library – Gymnasium")
    row.get_by_role("button", name="Cancel").click()
    console.get_by_role("dialog").get_by_role("button", name="Cancel the ride").click()
    expect(row).to_have_count(0)
    expect(phone.get_by_text("The operators cancelled this ride")).to_be_visible()


@pytest.mark.usefixtures("shuttle")
def test_who_rode_is_erased_for_good_after_a_question(console: Page, open_page: OpenPage) -> None:
    phone = open_page("/", allowed=(404,), **PHONE)
    code = book(phone, "Main Library", "Gymnasium")
    cancel(phone)
    console.get_by_role("link", name="Rides").click()
    console.get_by_role("button", name="All", exact=True).click()
    row = console.locator(f'[data-ride="{code}"]')
    ride_id = row.get_attribute("data-ride-id")
    row.get_by_role("button", name="Erase rider").click()
    console.get_by_role("dialog").get_by_role("button", name="Erase the rider").click()
    expect(row).to_have_count(0)
    erased = console.locator(f'[data-ride-id="{ride_id}"]')
    expect(erased).to_contain_text("rider erased")
    expect(erased).to_contain_text("Cancelled")
    expect(erased.get_by_role("button", name="Erase rider")).to_have_count(0)
    phone.reload()
    expect(phone.get_by_text(code)).to_have_count(0)


def test_a_viewer_sees_the_service_and_no_button_that_would_be_refused(
    console: Page, open_page: OpenPage, server: ServerProcess
) -> None:
    console.get_by_role("link", name="Service").click()
    expect(console.get_by_role("button", name="New calendar")).to_be_visible()
    name, password = server.new_viewer()
    page = open_page("/console")
    sign_in(page, password, name)
    page.get_by_role("link", name="Service").click()
    expect(page.get_by_role("heading", name="Calendars")).to_be_visible()
    for button in ("New calendar", "Edit", "Remove", "Add the day"):
        expect(page.get_by_role("button", name=button)).to_have_count(0)


def test_an_enrolment_code_and_a_token_are_made_and_the_token_revoked(console: Page) -> None:
    console.get_by_role("link", name="Access").click()
    console.get_by_label("Vehicle id").fill("shuttle-9")
    console.get_by_label("Name on the screen").fill("Shuttle 9")
    console.get_by_role("button", name="Create a code").click()
    expect(console.get_by_text("Code for shuttle-9")).to_be_visible()
    console.get_by_label("Token name").fill("night-tests")
    console.get_by_role("button", name="Create a token").click()
    expect(console.get_by_text("Copy it now")).to_be_visible()
    line = console.locator(".token", has_text="night-tests")
    line.get_by_role("button", name="Revoke").click()
    console.get_by_role("dialog").get_by_role("button", name="Revoke").click()
    expect(line).to_contain_text("revoked")


def test_a_holiday_is_entered_and_taken_back(console: Page, server: ServerProcess) -> None:
    console.get_by_role("link", name="Service").click()
    console.get_by_label("Day", exact=True).fill("2099-12-25")
    console.get_by_label("Name or reason").fill("Founding Day")
    console.get_by_role("button", name="Add the day").click()
    line = console.locator('[data-exception="2099-12-25"]')
    expect(line).to_contain_text("Founding Day")
    assert server.http.get("/timetable", params={"day": "2099-12-25"}).json()["holiday"] == "Founding Day"
    line.get_by_role("button", name="Remove").click()
    expect(line).to_have_count(0)


def test_a_calendar_is_entered_changed_and_removed(console: Page) -> None:
    console.get_by_role("link", name="Service").click()
    console.get_by_role("button", name="New calendar").click()
    console.get_by_label("Service id").fill("term")
    console.get_by_label("Name of the calendar").fill("Term")
    console.get_by_role("button", name="Save").click()
    line = console.locator('[data-service="term"]')
    expect(line).to_contain_text("Mon Tue Wed Thu Fri")
    line.get_by_role("button", name="Edit").click()
    console.get_by_label("Sat").check()
    console.get_by_label("Last day (optional)").fill("2099-01-15")
    console.get_by_role("button", name="Save").click()
    expect(line).to_contain_text("Sat")
    expect(line).to_contain_text("2099")
    line.get_by_role("button", name="Remove").click()
    expect(line).to_have_count(0)


def test_a_recorded_run_is_replayed_at_any_moment_and_speed(
    console: Page, server: ServerProcess, shuttle: ScriptedShuttle, tmp_path: Path
) -> None:
    record_run(tmp_path / "0.mcap", "shuttle-1", "boot-1", server.network, seconds=40)
    upload_run(shuttle, tmp_path / "0.mcap", server.http)
    console.get_by_role("link", name="Runs").click()
    console.locator("a[href*='boot-1']").click()
    screen = console.locator(".led")
    expect(screen).to_contain_text("second 0")
    console.get_by_label("Speed").select_option("10")
    console.get_by_role("button", name="Play").click()
    expect(screen).to_contain_text("second 40", timeout=WITHIN_MS)
    slider = console.get_by_label("Time in the run")
    slider.evaluate(
        "(range, part) => { range.value = Number(range.min) + (range.max - range.min) * part;"
        " range.dispatchEvent(new Event('input', { bubbles: true })); }",
        0.5,
    )
    expect(screen).to_contain_text("second 20")


def test_the_console_speaks_chinese(console: Page) -> None:
    console.get_by_role("button", name="中文").click()
    expect(console.locator("html")).to_have_attribute("lang", "zh-CN")
    expect(console.get_by_role("link", name="行程")).to_be_visible()


@pytest.mark.parametrize(
    "place", ["live", "live/shuttle-1", "rides", "service", "incidents", "runs", "access"]
)
def test_nothing_sticks_out_on_a_phone(open_page: OpenPage, server: ServerProcess, place: str) -> None:
    page = open_page("/console", **(PHONE | {"viewport": {"width": 360, "height": 740}}))
    sign_in(page)
    expect(page.locator(".console")).to_be_visible()
    page.goto(f"{server.origin}/console#/{place}")
    expect(page.locator("main h1, main h2, main canvas").first).to_be_visible()
    assert not sticks_out(page)
