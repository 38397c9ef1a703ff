"""Rides in the console: search, the page of one ride, and booking for a caller."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from benchmarks.web.accessibility import AXE
from tests.e2e.conftest import OpenPage
from tests.e2e.operator import sign_in
from tests.e2e.server_process import ServerProcess
from tests.e2e.targets import small_targets, sticks_out

pytestmark = [pytest.mark.browser, pytest.mark.real, pytest.mark.usefixtures("shuttle")]


def book(server: ServerProcess) -> dict[str, str]:
    stops = [stop["stop_id"] for stop in server.http.get("/stops").json()[:2]]
    ride: dict[str, str] = server.change(
        "POST", "/rides", {"from_stop": stops[0], "to_stop": stops[1], "party": 1}
    )
    assert ride["state"] == "assigned", ride
    return ride


def violations(page: Page) -> list[str]:
    page.evaluate(AXE.read_text())
    found = page.evaluate("axe.run()")
    return [f"{one['id']}: {one['nodes'][0]['html'][:160]}" for one in found["violations"]]


def look(page: Page, name: str, screenshots: Path | None) -> None:
    page.wait_for_timeout(300)
    if screenshots is not None:
        page.screenshot(path=screenshots / f"{name}.png", full_page=True)
    assert violations(page) == [], name
    assert small_targets(page, 44) == [], name
    assert not sticks_out(page), name


@pytest.mark.parametrize(("locale", "scheme"), [("en-GB", "light"), ("zh-CN", "dark")])
def test_a_ride_is_found_by_its_code_and_tells_its_story(
    open_page: OpenPage, server: ServerProcess, locale: str, scheme: str, screenshots: Path | None
) -> None:
    ride = book(server)
    page = open_page("/console", color_scheme=scheme)
    sign_in(page)
    if locale == "zh-CN":
        page.get_by_role("button", name="中文").click()
    expect(page.locator(".row").first).to_be_visible()
    page.goto(f"{server.origin}/console#/rides")
    page.locator(".ride-search input").first.fill(ride["ride_code"].lower())
    page.keyboard.press("Enter")
    row = page.locator("tbody tr")
    expect(row).to_have_count(1)
    look(page, f"console-rides-{locale}", screenshots)
    row.get_by_role("link", name=ride["ride_code"]).click()
    expect(page.locator("h1")).to_contain_text(ride["ride_code"])
    expect(page.locator(".decisions li")).to_have_count(1)
    expect(page.locator("[data-runner-up]")).to_have_text(
        re.compile("No other shuttle could have taken it|没有其他车辆可以接单|Next best|其次")
    )
    expect(page.locator(".history li").first).to_contain_text(re.compile("Booked|已预订"))
    page.get_by_role("button", name=re.compile("Compare with a plan|与没有此行程")).click()
    expect(page.locator(".delays li").first).to_be_visible()
    look(page, f"console-ride-{locale}", screenshots)
    server.change("POST", f"/rides/{ride['token']}/cancel", {})
    expect(page.locator(".history li").last).to_contain_text(re.compile("Cancelled|已取消"))


def test_an_operator_books_for_a_caller_by_keyboard(
    open_page: OpenPage, server: ServerProcess, screenshots: Path | None
) -> None:
    page = open_page("/console")
    sign_in(page)
    expect(page.locator(".row").first).to_be_visible()
    page.goto(f"{server.origin}/console#/rides")
    page.get_by_role("button", name="Book for a caller").press("Enter")
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("From").select_option(index=1)
    dialog.get_by_label("To", exact=True).select_option(index=2)
    dialog.get_by_role("button", name="Book", exact=True).press("Enter")
    expect(dialog.get_by_role("status")).to_contain_text("Tell the caller: ride")
    look(page, "console-caller", screenshots)
    code = dialog.get_by_role("status").get_attribute("data-ride-code")
    dialog.get_by_role("button", name="Show the ride").click()
    expect(page.locator("h1")).to_have_text(f"Ride {code}")
    expect(page.locator(".facts")).to_contain_text("by an operator")
    record = next(one for one in server.http.get(f"/rides?code={code}").json())
    server.change("POST", f"/rides/id/{record['ride_id']}/cancel", {})


def test_a_caller_who_is_refused_is_offered_what_could_be(open_page: OpenPage, server: ServerProcess) -> None:
    page = open_page("/console")
    sign_in(page)
    expect(page.locator(".row").first).to_be_visible()
    page.goto(f"{server.origin}/console#/rides")
    page.get_by_role("button", name="Book for a caller").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("From").select_option(index=1)
    dialog.get_by_label("To", exact=True).select_option(index=2)
    dialog.get_by_label("People").fill("4")
    dialog.get_by_label("Wheelchair places").fill("3")
    dialog.get_by_role("button", name="Book", exact=True).click()
    expect(dialog.get_by_role("status")).to_contain_text("Refused")
