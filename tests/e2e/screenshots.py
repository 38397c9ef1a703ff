"""`python -m tests.e2e.screenshots [FOLDER]`: pictures of both pages with shuttles on the road.

Starts a server with scripted shuttles and books rides as passengers do. Without FOLDER it refreshes the few
pictures that README shows, in docs/images; with one it writes every page there, to look at.
"""

import sys
import tempfile
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
README_PICTURES = frozenset(
    {"phone-booking", "phone-ride", "phone-ride-dark-zh", "console-vehicle", "console-live"}
)


class Camera:
    """Opens pages and files their pictures under names."""

    def __init__(self, browser: Browser, server: ServerProcess, folder: Path, wanted: frozenset[str]) -> None:
        """wanted: names of the pictures to take; empty for all."""
        self._browser, self._server, self._folder, self._wanted = browser, server, folder, wanted

    def open(self, path: str, **options: Any) -> Page:
        shape: dict[str, Any] = {"locale": "en-GB", "timezone_id": "Asia/Shanghai", "device_scale_factor": 2}
        page = self._browser.new_context(**(shape | options)).new_page()
        page.goto(self._server.origin + path)
        return page

    def take(self, page: Page, name: str) -> None:
        if self._wanted and name not in self._wanted:
            return
        page.wait_for_timeout(SETTLE_MS)
        page.screenshot(path=self._folder / f"{name}.png")
        print(self._folder / f"{name}.png")


def photograph(camera: Camera, shuttles: list[ScriptedShuttle]) -> None:
    for shuttle in shuttles:
        shuttle.speed_mps = 3.0
    booking = camera.open("/", **PHONE)
    fill_booking(booking, "Main Library", "Life Sciences")
    camera.take(booking, "phone-booking")
    chinese = camera.open("/", **PHONE, color_scheme="dark")
    ride_codes = photograph_rides(camera, chinese)
    print("rides:", ", ".join(ride_codes))
    photograph_console(camera)


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
        for title in ("Rides", "Incidents", "Runs", "Access"):
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


def main(folder: Path, wanted: frozenset[str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with (
        tempfile.TemporaryDirectory() as var,
        ServerProcess(Path(var)) as server,
        sync_playwright() as playwright,
    ):
        shuttles = [
            server.add_shuttle(f"shuttle-{number}", f"Shuttle {number}", resting_place=4 * number)
            for number in (1, 2, 3)
        ]
        record_run(Path(var) / "0.mcap", "shuttle-1", "boot-1", server.network, seconds=300)
        upload_run(shuttles[0], Path(var) / "0.mcap", server.http)
        browser = playwright.chromium.launch(executable_path=chromium_path(), args=list(LAUNCH_FLAGS))
        photograph(Camera(browser, server, folder, wanted), shuttles)
        browser.close()


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]), frozenset())
    else:
        main(ROOT / "docs" / "images", README_PICTURES)
