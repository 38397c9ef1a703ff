"""What a shuttle sees and plans: in the replay of its run, and live on request."""

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
    page = open_page("/console", allowed=(409,))
    sign_in(page)
    return page


def test_a_replay_shows_what_the_shuttle_saw_and_planned(
    console: Page,
    server: ServerProcess,
    shuttle: ScriptedShuttle,
    tmp_path: Path,
    screenshots: Path | None,
) -> None:
    record_run(tmp_path / "0.mcap", "shuttle-1", "boot-9", server.network, seconds=30, sees=True)
    upload_run(shuttle, tmp_path / "0.mcap", server.http)
    console.get_by_role("link", name="Runs").click()
    console.locator("a[href*='boot-9']").click()
    seen = console.get_by_role("region", name="What it sees and plans")
    graph = seen.get_by_role("img")
    expect(graph).to_have_accessible_name(
        "The chosen motion covers 7.0 m in 8 s; 2 tracks come onto the path."
    )
    expect(graph.locator("path.st-yielded")).to_have_count(1)
    expect(seen).to_contain_text("passes people slowly")
    expect(seen).to_contain_text("12 to 20 m: 5 km/h")
    expect(seen).to_contain_text("Slowest tick: 4.1 of 20 ms")
    expect(seen.get_by_role("row", name="planning")).to_contain_text("2.40 ms")
    # The first scan is of the first second.
    console.get_by_role("slider").press("End")
    things = seen.get_by_role("region", name="What it sees")
    expect(things).to_contain_text("found by its own lidars")
    expect(things).to_contain_text("pedestrian: 1")
    expect(things).to_contain_text("Stop sign, 12 m away")
    expect(things).to_contain_text("Sign, not read yet, 18 m away")
    expect(things).to_contain_text("160 lidar points above the road")
    things.get_by_text("4 road users, 0.1 s old").click()
    person = things.get_by_role("row").filter(has=console.get_by_role("rowheader", name="7", exact=True))
    expect(person).to_contain_text("pedestrian · gives way to")
    expect(person).to_contain_text("5.0 km/h")
    if screenshots is not None:
        seen.scroll_into_view_if_needed()
        console.screenshot(path=screenshots / "onboard-replay.png")


def test_a_run_of_an_older_agent_says_that_it_has_nothing_of_this(
    console: Page, server: ServerProcess, shuttle: ScriptedShuttle, tmp_path: Path
) -> None:
    record_run(tmp_path / "0.mcap", "shuttle-1", "boot-10", server.network, seconds=10)
    upload_run(shuttle, tmp_path / "0.mcap", server.http)
    console.get_by_role("link", name="Runs").click()
    console.locator("a[href*='boot-10']").click()
    seen = console.get_by_role("region", name="What it sees and plans")
    expect(seen).to_contain_text("The recording has nothing of this for this moment.")


def test_a_shuttle_shows_what_it_sees_on_request_and_its_age_is_told_when_it_ends(
    console: Page, screenshots: Path | None
) -> None:
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_text("What it sees and plans", exact=True).click()
    panel.get_by_role("button", name="Show what it sees").click()
    expect(panel).to_contain_text("passes people slowly")
    expect(panel).to_contain_text("Yield sign, 11 m away")
    expect(panel).to_contain_text("160 lidar points above the road")
    expect(panel.get_by_role("button", name="One minute more")).to_be_visible()
    if screenshots is not None:
        console.screenshot(path=screenshots / "onboard-live.png")
    # The scripted shuttle shows it for a few seconds only: then what is there grows old.
    expect(panel.get_by_text("What you see is")).to_be_visible()
    console.get_by_role("link", name="Audit log").click()
    expect(console.get_by_text("ask_for_scene").first).to_be_visible()


def test_a_shuttle_out_of_reach_is_not_asked(console: Page, server: ServerProcess) -> None:
    server.enter_vehicle("shuttle-silent", "Shuttle silent")
    panel = show_vehicle(console, "Shuttle silent")
    panel.get_by_text("What it sees and plans", exact=True).click()
    panel.get_by_role("button", name="Show what it sees").click()
    expect(panel.get_by_text("The server cannot reach the shuttle at the moment.")).to_be_visible()
