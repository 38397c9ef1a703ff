"""The console's localization maps: who uses which, put in force, rolled back, removed."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from contract.roads.load import load_map
from tests.contract.localization_folders import point_map
from tests.e2e.conftest import DESKTOP, WITHIN_MS
from tests.e2e.operator import sign_in
from tests.e2e.server_process import ServerProcess
from tests.server.feeds.roads.shipped import CAMPUS_MAP

pytestmark = [pytest.mark.browser, pytest.mark.real]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerProcess]:
    """A server of its own: its maps change."""
    with ServerProcess(tmp_path) as running:
        yield running


def send(server: ServerProcess, folder: Path, note: str, *, whole: bool = True) -> str:
    data = (folder / "index.json").read_bytes()
    typed = {"Content-Type": "application/json"}
    path = "/localization-maps"
    answer = server.http.post(path, content=data, headers=typed, params={"note": note})
    stored = answer.raise_for_status().json()
    version: str = stored["map_version"]
    for file in (folder / "tiles").iterdir() if whole else ():
        sha256 = next(one["sha256"] for one in _tiles(server, version) if one["file"] == f"tiles/{file.name}")
        server.http.put(f"{path}/{version}/tiles/{sha256}", content=file.read_bytes()).raise_for_status()
    return version


def _tiles(server: ServerProcess, version: str) -> list[dict[str, str]]:
    tiles: list[dict[str, str]] = server.http.get(f"/localization-maps/{version}/manifest").json()["tiles"]
    return tiles


def row(page: Page, note: str) -> Locator:
    return page.locator("li", has=page.get_by_text(note, exact=True))


def put_in_force(page: Page, note: str) -> None:
    row(page, note).get_by_role("button", name="Put in force").click()
    page.get_by_role("dialog").get_by_role("button", name="Put in force").click()


def test_a_map_is_put_in_force_rolled_back_and_removed(
    browser: Browser, server: ServerProcess, tmp_path: Path
) -> None:
    here = load_map(CAMPUS_MAP).origin
    for name, changed in (("August", 0), ("September", 1), ("October", 2)):
        point_map(tmp_path / name, here, changed=changed)
    page = browser.new_context(locale="en-GB", service_workers="block", **DESKTOP).new_page()
    page.set_default_timeout(WITHIN_MS)
    page.goto(f"{server.origin}/console#/maps")
    sign_in(page)
    expect(page.get_by_text("No localization map is stored.")).to_be_visible()
    for name in ("August", "September"):
        send(server, tmp_path / name, name)
    expect(row(page, "September")).to_contain_text("Surfaces, for lidars · 3 tiles")
    put_in_force(page, "August")
    expect(row(page, "August").get_by_text("In force", exact=True)).to_be_visible()
    put_in_force(page, "September")
    expect(row(page, "September").get_by_text("In force", exact=True)).to_be_visible()
    expect(row(page, "August").get_by_text("In force", exact=True)).to_have_count(0)
    put_in_force(page, "August")
    expect(row(page, "August").get_by_text("In force", exact=True)).to_be_visible()
    row(page, "September").get_by_role("button", name="Remove").click()
    page.get_by_role("dialog").get_by_role("button", name="Remove").click()
    expect(row(page, "September")).to_have_count(0)
    send(server, tmp_path / "October", "October", whole=False)
    expect(row(page, "October")).to_be_visible()
    put_in_force(page, "October")
    expect(page.get_by_text("Tiles of this map are missing.")).to_be_visible()
    expect(row(page, "August").get_by_text("In force", exact=True)).to_be_visible()
