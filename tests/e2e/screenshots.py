"""Pictures of both pages, with rides booked as passengers book them.

`python -m tests.e2e.screenshots FOLDER` starts a server with scripted shuttles and writes every page, to look
at. `... --live ORIGIN --password WORD` refreshes the pictures that README shows, from a demo that is running
without passengers of its own: `make demo ARGS=--no-people`.
"""

import argparse
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, sync_playwright

from tests.e2e.chromium import LAUNCH_FLAGS, chromium_path
from tests.e2e.operator import show_vehicle, sign_in
from tests.e2e.passenger import book, fill_booking
from tests.e2e.recorded_run import record_run, upload_run
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ROOT, ServerProcess

PHONE: dict[str, Any] = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
DESKTOP: dict[str, Any] = {"viewport": {"width": 1440, "height": 900}, "device_scale_factor": 1}
LOOKS: tuple[tuple[str, dict[str, Any]], ...] = (("", {}), ("-dark", {"color_scheme": "dark"}))
SETTLE_MS = 1500
FULL_SPEED_WITHIN_MS = 120_000


class Camera:
    """Opens pages and files their pictures under names."""

    def __init__(self, browser: Browser, origin: str, folder: Path) -> None:
        self._browser, self._origin, self._folder = browser, origin, folder

    def open(self, path: str, **options: Any) -> Page:
        shape: dict[str, Any] = {"locale": "en-GB", "timezone_id": "Asia/Shanghai", "device_scale_factor": 2}
        page = self._browser.new_context(**(shape | options)).new_page()
        page.goto(self._origin + path)
        return page

    def take(self, page: Page, name: str) -> None:
        page.wait_for_timeout(SETTLE_MS)
        page.screenshot(path=self._folder / f"{name}.png")
        print(self._folder / f"{name}.png")


def photograph(camera: Camera, shuttles: list[ScriptedShuttle]) -> None:
    for shuttle in shuttles:
        shuttle.speed_mps = 3.0
    booking = camera.open("/", **PHONE)
    fill_booking(booking, "Main Library", "Life Sciences")
    camera.take(booking, "phone-booking")
    photograph_repeat(camera)
    chinese = camera.open("/", **PHONE, color_scheme="dark")
    ride_codes = photograph_rides(camera, chinese)
    print("rides:", ", ".join(ride_codes))
    photograph_console(camera)


def photograph_repeat(camera: Camera) -> None:
    phone = camera.open("/", **PHONE)
    fill_booking(phone, "Main Library", "Gymnasium")
    phone.get_by_role("button", name="Repeat").click()
    camera.take(phone, "phone-repeat")
    phone.get_by_role("button", name="Book all these days").click()
    phone.locator("[data-day]").first.wait_for()
    camera.take(phone, "phone-series")


def photograph_live(camera: Camera, password: str) -> None:
    """Two rides on a running campus, their shuttles under way."""
    phone = camera.open("/", **PHONE)
    fill_booking(phone, "Main Library", "Life Sciences")
    camera.take(phone, "phone-booking")
    other = camera.open("/", **PHONE, color_scheme="dark")
    book(other, "Academy of Fine Arts", "Management Building")
    other.get_by_role("button", name="中文").click()
    phone.get_by_role("button", name="Book the ride").click()
    console = camera.open("/console", **DESKTOP)
    sign_in(console, password)
    moving = console.locator(".row", has_text=re.compile(r"[5-9] km/h|1\d km/h"))
    moving.first.wait_for(timeout=FULL_SPEED_WITHIN_MS)
    camera.take(console, "console-live")
    moving.first.click()
    camera.take(console, "console-vehicle")
    camera.take(phone, "phone-ride")
    camera.take(other, "phone-ride-dark-zh")


def photograph_rides(camera: Camera, chinese: Page) -> list[str]:
    phone = camera.open("/", **PHONE)
    codes = [book(phone, "Main Library", "Life Sciences")]
    other = camera.open("/", **DESKTOP)
    codes.append(book(other, "Gymnasium", "Building J"))
    camera.take(phone, "phone-ride")
    camera.take(other, "desktop-ride")
    codes.append(book(chinese, "Academy of Fine Arts", "Management Building"))
    chinese.get_by_role("button", name="中文").click()
    camera.take(chinese, "phone-ride-dark-zh")
    phone.get_by_role("button", name="Change destination").click()
    camera.take(phone, "phone-destination")
    phone.get_by_role("button", name="Back").click()
    phone.get_by_role("button", name="Help").click()
    camera.take(phone, "phone-help")
    phone.get_by_role("button", name="Call for help").click()
    camera.take(phone, "phone-help-received")
    return codes


def photograph_console(camera: Camera) -> None:
    for suffix, look in LOOKS:
        console = camera.open("/console", **DESKTOP, **look)
        camera.take(console, f"console-sign-in{suffix}")
        sign_in(console)
        console.locator(".row").first.wait_for()
        camera.take(console, f"console-live{suffix}")
        show_vehicle(console, "Shuttle 1")
        camera.take(console, f"console-vehicle{suffix}")
        for title in ("Rides", "Service", "Incidents", "Runs", "Access"):
            console.get_by_role("link", name=title).click()
            camera.take(console, f"console-{title.lower()}{suffix}")
        console.goto(console.url.split("#")[0] + "#/runs/shuttle-1/boot-1")
        console.get_by_role("button", name="Play").click()
        camera.take(console, f"console-replay{suffix}")
    phone = camera.open("/console", **PHONE)
    sign_in(phone)
    phone.locator(".row").first.wait_for()
    camera.take(phone, "console-phone")
    show_vehicle(phone, "Shuttle 1")
    camera.take(phone, "console-phone-vehicle")
    phone.get_by_role("link", name="Rides").click()
    camera.take(phone, "console-phone-rides")


def photograph_scripted(folder: Path) -> None:
    with (
        tempfile.TemporaryDirectory() as var,
        ServerProcess(Path(var)) as server,
        chromium() as browser,
    ):
        shuttles = [
            server.add_shuttle(f"shuttle-{number}", f"Shuttle {number}", resting_place=4 * number)
            for number in (1, 2, 3)
        ]
        record_run(Path(var) / "0.mcap", "shuttle-1", "boot-1", server.network, seconds=300)
        upload_run(shuttles[0], Path(var) / "0.mcap", server.http)
        photograph(Camera(browser, server.origin, folder), shuttles)


@contextmanager
def chromium() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium_path(), args=list(LAUNCH_FLAGS))
        yield browser
        browser.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=ROOT / "docs" / "images")
    parser.add_argument("--live", default="", metavar="ORIGIN", help="of a running demo")
    parser.add_argument("--password", default="", help="the operator's, as the demo prints it")
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    if asked.live:
        with chromium() as browser:
            photograph_live(Camera(browser, asked.live, asked.folder), asked.password)
    else:
        photograph_scripted(asked.folder)


if __name__ == "__main__":
    main()
