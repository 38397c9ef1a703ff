"""A file that nobody has seen before becomes the map in force, and is booked on."""

import math
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from contract.roads.load import decode_map
from contract.roads.network import RoadNetwork
from server.feeds.roads.generated import generated_osm
from tests.e2e.campus_map import place_px
from tests.e2e.conftest import DESKTOP, WITHIN_MS
from tests.e2e.operator import sign_in
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real]

SEED = 7
PUBLISHED_WITHIN_MS = 120_000


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerProcess]:
    """A server of its own: its map changes."""
    with ServerProcess(tmp_path) as running:
        yield running


def console(browser: Browser, server: ServerProcess, path: str = "/console#/maps") -> Page:
    page = browser.new_context(locale="en-GB", service_workers="block", **DESKTOP).new_page()
    page.set_default_timeout(WITHIN_MS)
    page.goto(f"{server.origin}{path}")
    sign_in(page)
    return page


def imported(page: Page, tmp_path: Path) -> None:
    source = tmp_path / "unseen.osm"
    source.write_bytes(generated_osm(SEED))
    page.get_by_label("Map file").set_input_files(source)
    page.get_by_role("button", name="Import", exact=True).click()
    expect(page.get_by_text("This file is of another place.")).to_be_visible()
    expect(page.get_by_text("km from")).to_be_visible()
    page.get_by_role("button", name="Import it all the same").click()
    expect(page.get_by_text("unseen.osm is a draft now.")).to_be_visible()
    page.get_by_role("link", name="Open it").click()


def test_an_unseen_file_is_imported_mended_published_and_booked_on(
    browser: Browser, server: ServerProcess, tmp_path: Path
) -> None:
    page = console(browser, server)
    imported(page, tmp_path)
    expect(page.get_by_text("No problems. There is room for")).to_be_visible()
    # A zone over the first stop, entered by another program: the page finds the problem and mends it.
    (draft,) = server.http.get("/maps/drafts").json()
    path = f"/maps/drafts/{draft['draft_id']}"
    stop, other = server.http.get(path).json()["elements"]["stops"][:2]
    zone = {"zone_id": "z", "lane_id": stop["lane_id"], "s_from_m": stop["s_m"], "s_to_m": stop["s_m"] + 1.0}
    answer = server.http.patch(path, json={"put": {"no_stopping_zones": [zone]}}, headers={"If-Match": "1"})
    assert answer.is_success, answer.text
    page.reload()
    expect(page.get_by_text("Stands in a no-stopping zone")).to_be_visible()
    page.get_by_role("button", name="Show", exact=True).click()
    expect(page.get_by_role("heading", name="Stop", exact=False).first).to_be_visible()
    expect(page.get_by_role("button", name="Compare and publish")).to_be_disabled()
    page.get_by_role("button", name="Mend").click()
    expect(page.get_by_text("No problems. There is room for")).to_be_visible()
    page.get_by_label("From stop").select_option(stop["stop_id"])
    page.get_by_label("To stop").select_option(other["stop_id"])
    expect(page.locator(".trial-time")).to_contain_text("min")
    page.get_by_role("button", name="Compare and publish").click()
    page.get_by_role("dialog").get_by_role("button", name="Publish").click()
    expect(page.get_by_role("heading", name="Versions")).to_be_visible(timeout=PUBLISHED_WITHIN_MS)
    expect(page.get_by_text("There are no drafts.")).to_be_visible()
    version = server.http.get("/campus").json()["map_version"]
    server.network = RoadNetwork(decode_map(server.http.get(f"/maps/{version}/exports/map").content))
    server.add_shuttle("shuttle-1", "Shuttle 1", resting_place=0)
    wish = {"from_stop": stop["stop_id"], "to_stop": other["stop_id"], "party": 1}
    assert server.change("POST", "/rides", wish)["state"] == "assigned"
    page.get_by_role("button", name="Put in force").click()
    page.get_by_role("dialog").get_by_role("button", name="Put in force").click()
    expect(page.get_by_text("Shuttles are under way with the present map.")).to_be_visible()


def test_steps_by_keyboard_are_undone_and_redone(browser: Browser, server: ServerProcess) -> None:
    page = console(browser, server)
    page.get_by_role("button", name="Draw on the current map").click()
    expect(page.get_by_text("Saved, revision 1")).to_be_visible()
    page.get_by_role("button", name="Add stop").click()
    page.get_by_role("application").press("Enter")
    expect(page.get_by_text("Saved, revision 2")).to_be_visible()
    name = page.get_by_label("English name")
    name.fill("South gate")
    name.press("Enter")
    expect(page.get_by_text("Saved, revision 3")).to_be_visible()
    draft_id = page.url.rsplit("/", 1)[1]

    def names() -> list[str]:
        stops = server.http.get(f"/maps/drafts/{draft_id}").json()["elements"]["stops"]
        return [stop["name_en"] for stop in stops]

    assert names()[-1] == "South gate"
    page.get_by_role("button", name="Undo").click()
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_text("Saved, revision 5")).to_be_visible()
    assert len(names()) == 16
    page.get_by_role("button", name="Redo").click()
    expect(page.get_by_text("Saved, revision 6")).to_be_visible()
    assert len(names()) == 17


def test_two_operators_on_one_draft_keep_both_versions(browser: Browser, server: ServerProcess) -> None:
    pages = [console(browser, server)]
    pages[0].get_by_role("button", name="Draw on the current map").click()
    expect(pages[0].get_by_text("Saved, revision 1")).to_be_visible()
    draft_id = pages[0].url.rsplit("/", 1)[1]
    pages.append(console(browser, server, f"/console#/maps/{draft_id}"))
    for page in pages:
        expect(page.get_by_text("Saved, revision 1")).to_be_visible()
        page.get_by_role("button", name="Add stop").click()
    pages[0].get_by_role("application").press("Enter")
    expect(pages[0].get_by_text("Saved, revision 2")).to_be_visible()
    pages[1].get_by_role("application").press("ArrowLeft")
    pages[1].get_by_role("application").press("Enter")
    expect(pages[1].get_by_text("Someone else has changed this draft.")).to_be_visible()
    pages[1].get_by_role("button", name="Keep mine as a draft of its own").click()
    expect(pages[1].get_by_role("heading", name="(mine)")).to_be_visible()
    assert len(server.http.get("/maps/drafts").json()) == 2


def test_a_lane_is_dragged_with_the_mouse_saved_and_taken_back(
    browser: Browser, server: ServerProcess, tmp_path: Path
) -> None:
    page = console(browser, server)
    imported(page, tmp_path)
    (draft,) = server.http.get("/maps/drafts").json()
    path = f"/maps/drafts/{draft['draft_id']}"

    def lanes() -> dict[str, list[list[float]]]:
        found = server.http.get(path).json()["elements"]["lanes"]
        return {lane["lane_id"]: lane["points"] for lane in found}

    before = lanes()
    # Small things are meant before large ones: a place far from all stops.
    stops = [
        before[stop["lane_id"]][min(round(stop["s_m"]), len(before[stop["lane_id"]]) - 1)]
        for stop in server.http.get(path).json()["elements"]["stops"]
    ]
    middles = [points[len(points) // 2] for points in before.values()]
    middle = max(middles, key=lambda at: min(math.dist(at, stop) for stop in stops))
    ends = [points[end] for points in before.values() for end in (0, -1)]
    page.get_by_role("button", name="Move", exact=True).click()
    canvas = page.get_by_role("application")
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box is not None
    x_px, y_px = place_px(canvas, ends, middle)
    page.mouse.move(box["x"] + x_px, box["y"] + y_px)
    page.mouse.down()
    page.mouse.move(box["x"] + x_px + 15, box["y"] + y_px + 5, steps=5)
    page.mouse.move(box["x"] + x_px + 30, box["y"] + y_px + 20, steps=5)
    # Dragging saves nothing until it is put down.
    assert lanes() == before
    page.mouse.up()
    expect(page.get_by_text("Saved, revision 2")).to_be_visible()
    after = lanes()
    (moved,) = [lane_id for lane_id in before if after[lane_id] != before[lane_id]]
    assert (after[moved][0], after[moved][-1]) == (before[moved][0], before[moved][-1])
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_text("Saved, revision 3")).to_be_visible()
    assert lanes() == before
