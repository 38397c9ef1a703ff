"""Marks and recordings on the console: what the shuttle has, and what only the server has."""

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
    page = open_page("/console")
    sign_in(page)
    return page


def test_a_moment_is_marked_and_a_recording_started_and_stopped(
    console: Page, screenshots: Path | None
) -> None:
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_text("Recording", exact=True).click()
    panel.get_by_label("Note on this moment").fill("Braked for a shadow?")
    panel.get_by_role("button", name="Mark", exact=True).click()
    expect(panel.get_by_text("Marked. The shuttle writes it into its file.")).to_be_visible()
    expect(panel.get_by_label("Note on this moment")).to_have_value("")
    expect(panel.locator(".last-command", has_text="Mark")).to_contain_text("done")
    panel.get_by_label("Name of the recording").fill("Crossing, rain")
    panel.get_by_role("button", name="Start recording").click()
    line = panel.locator(".last-command", has_text="Crossing, rain")
    expect(line.locator("strong")).to_have_text("recording")
    if screenshots is not None:
        console.screenshot(path=screenshots / "recording-panel.png")
    panel.get_by_role("button", name="Stop recording").click()
    expect(line.locator("strong")).to_have_text("ended, files on their way")
    console.get_by_role("link", name="Runs").click()
    recordings = console.get_by_role("region", name="Recordings")
    expect(recordings.locator("tr", has_text="Crossing, rain")).to_contain_text("files on their way")
    if screenshots is not None:
        console.screenshot(path=screenshots / "recordings.png")
    console.get_by_role("button", name="Replay the fleet").click()
    happened = console.get_by_role("region", name="What happened")
    expect(happened).to_contain_text("marked: “Braked for a shadow?” (operator)")
    expect(happened).to_contain_text("recording begins: “Crossing, rain” (operator)")


def test_a_shuttle_out_of_reach_is_told_as_that(console: Page, server: ServerProcess) -> None:
    server.enter_vehicle("shuttle-away", "Shuttle away")
    panel = show_vehicle(console, "Shuttle away")
    panel.get_by_text("Recording", exact=True).click()
    panel.get_by_label("Note on this moment").fill("Where is it?")
    panel.get_by_role("button", name="Mark", exact=True).click()
    expect(panel.get_by_text("Marked on the server only")).to_be_visible()
    expect(panel.locator(".last-command", has_text="Mark")).to_contain_text("waiting for the shuttle")
    panel.get_by_label("Name of the recording").fill("Nobody hears this")
    panel.get_by_role("button", name="Start recording").click()
    line = panel.locator(".last-command", has_text="Nobody hears this")
    expect(line).to_contain_text("waiting for the shuttle")
    expect(line).to_contain_text("The shuttle is out of reach and has not confirmed this.")


def test_marks_in_a_runs_file_are_on_its_timeline(
    console: Page, server: ServerProcess, shuttle: ScriptedShuttle, tmp_path: Path
) -> None:
    record_run(tmp_path / "0.mcap", "shuttle-1", "boot-8", server.network, seconds=30, mark=(17, "Look here"))
    upload_run(shuttle, tmp_path / "0.mcap", server.http)
    console.get_by_role("link", name="Runs").click()
    console.locator("a[href*='boot-8']").click()
    happened = console.get_by_role("region", name="What happened")
    happened.get_by_role("button", name="marked: “Look here”").click()
    expect(console.locator(".led")).to_contain_text("second 17")
