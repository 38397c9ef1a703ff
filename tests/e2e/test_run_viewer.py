"""`campusloop view`: the replay of a folder of run logs, at once and without a password."""

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from playwright.sync_api import Browser, expect

from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from tests.e2e.recorded_run import record_run
from tests.e2e.server_process import CAMPUS_MAP, ROOT, free_port

pytestmark = [pytest.mark.browser, pytest.mark.real]

READY_WITHIN_S = 240.0


@pytest.fixture(scope="module")
def viewer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The origin of a viewer of one run."""
    folder = tmp_path_factory.mktemp("runs")
    record_run(
        folder / "0000.mcap",
        "shuttle-7",
        "boot-7",
        RoadNetwork(load_map(CAMPUS_MAP)),
        40,
        doubts_at_s=30,
        scans=True,
    )
    port = free_port()
    command = [sys.executable, "-m", "campusloop", "view", str(folder), "--port", str(port)]
    with (folder / "view.log").open("wb") as journal:
        process = subprocess.Popen(command, cwd=ROOT, stdout=journal, stderr=subprocess.STDOUT)
    try:
        yield _ready(process, f"http://127.0.0.1:{port}", folder / "view.log")
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(20)


def _ready(process: "subprocess.Popen[bytes]", origin: str, journal: Path) -> str:
    until_s = time.monotonic() + READY_WITHIN_S
    while time.monotonic() < until_s:
        assert process.poll() is None, journal.read_text()
        if "Ctrl-C stops it" in journal.read_text():
            return origin
        time.sleep(0.1)
    raise AssertionError(journal.read_text())


def test_the_root_is_the_replay_and_asks_for_no_password(viewer: str, browser: Browser) -> None:
    context = browser.new_context(locale="en-GB")
    page = context.new_page()
    page.goto(viewer)
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    expect(page.locator(".led")).to_contain_text("second 0")
    expect(page.get_by_label("Password")).to_have_count(0)
    # Three quarters of the way it knew its place.
    row = page.get_by_role("img", name="scans agree with the map 7")
    expect(row).to_have_accessible_name(re.compile(r"in doubt, drives slowly 2\d %"))
    expect(row.locator(".phase-doubtful")).to_have_attribute("d", re.compile("v-8h1v8z"))
    page.reload()
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    context.close()


def test_a_scan_is_laid_over_the_map_when_it_is_asked_for(viewer: str, browser: Browser) -> None:
    context = browser.new_context(locale="en-GB")
    page = context.new_page()
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url) if "/scans?" in request.url else None)
    page.goto(viewer)
    block = page.get_by_role("region", name="Scan against the point map")
    expect(block.get_by_role("button", name="Show the scan")).to_be_visible()
    expect(page.locator(".led")).to_contain_text("second 0")
    assert asked == []
    block.get_by_role("button", name="Show the scan").click()
    # The first scan comes after a second.
    expect(block).to_contain_text("no scan at this moment")
    page.get_by_label("Time in the run").evaluate(
        "(range) => { range.value = Number(range.min) + 10000;"
        " range.dispatchEvent(new Event('input', { bubbles: true })); }"
    )
    expect(block).to_contain_text("on the map: 75 %")
    expect(block).to_contain_text("not in the map: 25 %")
    assert len(asked) >= 1
    block.get_by_role("button", name="Hide the scan").click()
    expect(block).not_to_contain_text("75 %")
    context.close()


def test_no_other_host_gets_a_session(viewer: str) -> None:
    answer = httpx.get(viewer, headers={"Host": "evil.example"}, trust_env=False)
    assert "set-cookie" not in answer.headers
