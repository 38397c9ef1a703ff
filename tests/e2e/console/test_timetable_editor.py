"""A dispatcher edits the timetable: trips, a preview, another operator meanwhile, and back again."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.e2e.conftest import DESKTOP, WITHIN_MS, OpenPage
from tests.e2e.operator import sign_in
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real]


def hour_without_departures(server: ServerProcess) -> str:
    """Hours from now, so that the shuttles of other tests stay free."""
    zone = ZoneInfo(server.http.get("/campus").json()["timezone"])
    return (datetime.now(UTC).astimezone(zone) + timedelta(hours=6)).strftime("%H")


def fill_trip(page: Page, trip_id: str, *calls: tuple[str, str]) -> None:
    page.get_by_role("button", name="New trip").click()
    page.get_by_label("Trip id").fill(trip_id)
    for number, (stop, leaves) in enumerate(calls, 1):
        page.get_by_label(f"Stop {number}", exact=True).select_option(label=stop)
        page.get_by_label(f"Leaves stop {number} at").fill(leaves)
    page.get_by_role("button", name="Keep the trip").click()


def preview(page: Page) -> None:
    page.locator(".timetable-editor").get_by_role("button", name="Preview").click()


def publish_as_another(server: ServerProcess, trips: list[object], revision: int) -> None:
    headers = {"If-Match": str(revision)}
    answer = server.http.put("/service/trips", json={"trips": trips}, headers=headers)
    assert answer.is_success, answer.text


def test_a_timetable_is_edited_previewed_and_published_and_no_version_is_lost(
    open_page: OpenPage, server: ServerProcess
) -> None:
    hour = hour_without_departures(server)
    begun = server.http.get("/service/trips").json()
    page = open_page("/console#/service", allowed=(400, 412))
    sign_in(page)
    page.get_by_role("button", name="Edit the timetable").click()
    fill_trip(page, "evening-1", ("Main Library", f"{hour}:30"), ("Gymnasium", f"{hour}:10"))
    preview(page)
    expect(page.get_by_text("no later than")).to_be_visible()
    trip = page.locator("[data-edited-trip='evening-1']")
    trip.get_by_role("button", name="Edit").click()
    page.get_by_label("Leaves stop 2 at").fill(f"{hour}:31")
    page.get_by_role("button", name="Keep the trip").click()
    preview(page)
    expect(page.get_by_text("Shuttles are late here, because driving takes longer:")).to_be_visible()
    expect(page.get_by_text("the trip gives 1 min")).to_be_visible()
    trip.get_by_role("button", name="Edit").click()
    page.get_by_label("Leaves stop 2 at").fill(f"{hour}:45")
    page.get_by_role("button", name="Keep the trip").click()
    preview(page)
    effect = page.locator("[data-timetable-effect]")
    expect(effect).to_contain_text("New trips: evening-1")
    expect(effect).to_contain_text("No departure of the coming hour is affected.")
    publish_as_another(server, [], begun["revision"])
    page.get_by_role("button", name="Publish", exact=True).click()
    expect(page.get_by_text("Nothing was overwritten")).to_be_visible()
    page.get_by_role("button", name="Publish mine after theirs").click()
    preview(page)
    page.get_by_role("button", name="Publish", exact=True).click()
    expect(page.locator("[data-trip='evening-1']")).to_contain_text(f"{hour}:30")
    page.get_by_role("button", name="Edit the timetable").click()
    page.get_by_text("Earlier versions").click()
    page.get_by_role("button", name="Take the map’s").click()
    preview(page)
    expect(effect).to_contain_text("Removed trips: evening-1")
    page.get_by_role("button", name="Publish", exact=True).click()
    expect(page.locator("[data-trip='evening-1']")).to_have_count(0)
    versions = server.http.get("/service/trips").json()["versions"]
    assert [one["trips"] for one in versions[:3]] == [len(begun["trips"]), len(begun["trips"]) + 1, 0]


@pytest.fixture
def own_server(tmp_path: Path) -> Iterator[ServerProcess]:
    """Its map changes."""
    with ServerProcess(tmp_path) as running:
        yield running


def test_trips_whose_stop_the_new_map_lacks_are_named_where_the_timetable_is_edited(
    browser: Browser, own_server: ServerProcess
) -> None:
    server, hour = own_server, hour_without_departures(own_server)
    page = browser.new_context(locale="en-GB", service_workers="block", **DESKTOP).new_page()
    page.set_default_timeout(WITHIN_MS)
    page.goto(f"{server.origin}/console#/service")
    sign_in(page)
    page.get_by_role("button", name="Edit the timetable").click()
    fill_trip(page, "evening-2", ("Main Library", f"{hour}:30"), ("Gymnasium", f"{hour}:45"))
    preview(page)
    page.get_by_role("button", name="Publish", exact=True).click()
    expect(page.locator("[data-trip='evening-2']")).to_be_visible()
    draft = server.change("POST", "/maps/drafts", {"name": "Without the gymnasium"})
    path = f"/maps/drafts/{draft['draft_id']}"
    stops = server.http.get(path).json()["elements"]["stops"]
    (gone,) = [stop["stop_id"] for stop in stops if stop["name_en"] == "Gymnasium"]
    answer = server.http.patch(path, json={"removed": {"stops": [gone]}}, headers={"If-Match": "1"})
    assert answer.is_success, answer.text
    answer = server.http.post(f"{path}/publications", headers={"If-Match": "2"})
    assert answer.is_success, answer.text
    page.reload()
    page.get_by_role("button", name="Edit the timetable").click()
    expect(page.get_by_text("These trips do not run. The map lacks stops of theirs:")).to_be_visible()
    expect(page.get_by_text(f"evening-2: no stop {gone}")).to_be_visible()
