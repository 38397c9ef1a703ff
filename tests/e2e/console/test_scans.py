"""The console asks for scans of an area, has a map made of them, and publishes it."""

import hashlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from contract.roads.load import load_map
from contract.wire.scans import parcel_path, signed_parcel
from contract.wire.upload import SIGNATURE_HEADER
from tests.e2e.conftest import DESKTOP, WITHIN_MS
from tests.e2e.operator import sign_in
from tests.e2e.server_process import CAMPUS_MAP, ServerProcess
from tests.server.fleet.vehicle_key import VehicleKeyPair
from tests.workshop.scan_maps.street import walls, write_drive

pytestmark = [pytest.mark.browser, pytest.mark.real]

KEY = VehicleKeyPair("shuttle-1")
# Mapping a street of 64 m in a child process takes some seconds.
MADE_WITHIN_MS = 300_000


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerProcess]:
    """A server of its own: its maps change."""
    with ServerProcess(tmp_path) as running:
        yield running


def send_scans(server: ServerProcess, folder: Path) -> None:
    """A vehicle answers the open request."""
    new = {"vehicle_id": "shuttle-1", "name": "One", "seats": 6, "wheelchair_places": 0}
    code = server.change("POST", "/enrolments/codes", new)["code"]
    key = {"code": code, "vehicle_id": "shuttle-1", "public_key": KEY.public_base64}
    server.change("POST", "/enrolments", key)
    road_map = load_map(CAMPUS_MAP)
    (request,) = [one for one in server.http.get("/scan-requests").json() if one["state"] == "open"]
    parcels = write_drive(
        folder, walls(), origin=road_map.origin, step_m=1.0, request_id=request["request_id"],
        campus_id=road_map.campus_id,
    )  # fmt: skip
    for parcel in parcels:
        data = parcel.read_bytes()
        sha256 = hashlib.sha256(data).hexdigest()
        headers = {
            "Vehicle-Id": "shuttle-1",
            SIGNATURE_HEADER: KEY.sign(signed_parcel("shuttle-1", sha256)),
        }
        path = parcel_path(sha256).removeprefix("/api/v1")
        server.http.put(path, content=data, headers=headers).raise_for_status()


def card(page: Page, heading: str) -> Locator:
    return page.locator("section.card", has=page.get_by_role("heading", name=heading, exact=True))


def test_scans_are_asked_for_and_the_map_made_of_them_is_published(
    browser: Browser, server: ServerProcess, tmp_path: Path
) -> None:
    page = browser.new_context(locale="en-GB", service_workers="block", **DESKTOP).new_page()
    page.set_default_timeout(WITHIN_MS)
    page.goto(f"{server.origin}/console#/maps")
    sign_in(page)
    scans, proposals = card(page, "Scans for a new map"), card(page, "Proposed maps")
    expect(scans.get_by_text("No scans were asked for yet.")).to_be_visible()

    # An area by clicks; one far from every road is refused.
    scans.get_by_label("What the scans are for").fill("Library")
    scans.get_by_label("Area", exact=True).select_option(label="An area on the map")
    expect(scans.get_by_role("button", name="Ask for scans")).to_be_disabled()
    canvas = scans.locator("canvas").first
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box is not None
    for x, y in ((0.3, 0.3), (0.7, 0.3), (0.7, 0.7), (0.3, 0.7)):
        canvas.click(position={"x": x * box["width"], "y": y * box["height"]})
    expect(scans.get_by_text("4 corners")).to_be_visible()
    scans.get_by_role("button", name="Ask for scans").click()
    expect(scans.get_by_text("Open", exact=True)).to_be_visible()
    (request,) = server.http.get("/scan-requests").json()
    assert len(request["outline"]) == 4
    scans.get_by_label("What the scans are for").fill("Again")
    scans.get_by_label("Area", exact=True).select_option(label="Whole campus")
    scans.get_by_role("button", name="Ask for scans").click()
    expect(scans.get_by_text("were asked for already")).to_be_visible()

    send_scans(server, tmp_path / "parcels")
    expect(
        scans.get_by_text("shuttle-1: has not said anything yet. 64 scans on 62 m have come")
    ).to_be_visible()
    scans.get_by_role("button", name="End").click()
    expect(scans.get_by_text("Ended by an operator")).to_be_visible()

    scans.get_by_role("button", name="Make a map").click()
    expect(proposals.get_by_text("Ready for a decision")).to_be_visible(timeout=MADE_WITHIN_MS)
    expect(proposals.get_by_text("Nothing can be compared")).to_be_visible()
    picture = proposals.get_by_role("img", name="Library: both maps from above")
    picture.scroll_into_view_if_needed()
    expect(picture).to_have_js_property("complete", True)
    assert picture.evaluate("image => image.naturalWidth") > 500
    proposals.get_by_role("button", name="Publish").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Note").fill("First map of the street.")
    dialog.get_by_role("button", name="Publish").click()
    expect(proposals.get_by_text("Published by operator")).to_be_visible()
    maps = card(page, "Localization maps")
    expect(maps.get_by_text("First map of the street.")).to_be_visible()
    expect(maps.get_by_text("In force", exact=True)).to_be_visible()

    # Of the same scans nothing has changed; that proposal is dismissed.
    scans.get_by_role("button", name="Make a map").click()
    expect(proposals.get_by_text("Ready for a decision")).to_be_visible(timeout=MADE_WITHIN_MS)
    expect(proposals.get_by_text("0 of 8 tiles differ")).to_be_visible()
    proposals.get_by_role("button", name="Dismiss").click()
    dialog.get_by_role("button", name="Dismiss").click()
    expect(proposals.get_by_text("Dismissed by operator")).to_be_visible()
