"""What a passenger waits and taps for: the first load, the first booking, and a page that only stays open."""

import re
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, expect

from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess

PHONE: dict[str, Any] = {
    "viewport": {"width": 390, "height": 844},
    "device_scale_factor": 3,
    "has_touch": True,
    "is_mobile": True,
    "locale": "en-GB",
}
# What the form waits for, besides what the page itself names.
_DATA = ("/api/v1/campus", "/api/v1/stops")
_SETTLE_MS = 3_000
_TICKET_WITHIN_MS = 30_000


@dataclass(frozen=True, slots=True)
class Booking:
    """taps: from the empty page to the ticket; seconds: without pauses, the first load included."""

    taps: int
    seconds: float


def first_load_kb(browser: Browser, server: ServerProcess) -> float:
    """Over the wire until a booking is possible: page, scripts, styles, texts, campus, stops; with headers."""
    context = browser.new_context(**PHONE)
    page = context.new_page()
    network = context.new_cdp_session(page)
    network.send("Network.enable")
    addresses: dict[str, str] = {}
    sizes: dict[str, float] = {}
    network.on("Network.responseReceived", lambda e: addresses.update({e["requestId"]: e["response"]["url"]}))
    network.on("Network.loadingFinished", lambda e: sizes.update({e["requestId"]: e["encodedDataLength"]}))
    page.goto(server.origin)
    page.wait_for_timeout(_SETTLE_MS)
    # As the server sent it: what comes after the form is named in the page only later.
    served = page.request.get(server.origin).text()
    named = set(re.findall(r'(?:src|href)="(/assets/[^"]+)"', served))
    language = re.compile(r"/assets/(english|problem_texts_en)-")
    named |= {path for path in (url.removeprefix(server.origin) for url in addresses.values()) if language.match(path)}
    wanted = {server.origin + path for path in ("/", *named, *_DATA)}
    context.close()
    return sum(size for request, size in sizes.items() if addresses.get(request) in wanted) / 1000.0


def first_booking(browser: Browser, server: ServerProcess, screenshots: Path | None) -> Booking:
    """The fewest taps that the page offers a first visitor, and how long they take a script."""
    context = browser.new_context(**PHONE)
    page = context.new_page()
    begun_s = time.perf_counter()
    page.goto(server.origin)
    choices = page.locator(".stop-choice")
    taps = 0
    # A page that shows its stops at once needs no tap on the fields.
    for number, end in enumerate(("From", "To")):
        page.locator(".stop-field").nth(number).wait_for()
        if choices.count() == 0:
            page.get_by_role("button", name=re.compile(f"^{end}")).tap()
            taps += 1
        choices.nth(2 + number).tap()
        taps += 1
    page.locator(".book-bar button").tap()
    taps += 1
    expect(page.locator("[data-ride-code]")).to_be_visible(timeout=_TICKET_WITHIN_MS)
    seconds = time.perf_counter() - begun_s
    if screenshots is not None:
        page.screenshot(path=screenshots / "first-booking.png")
    _cancel(page, server)
    context.close()
    return Booking(taps, seconds)


def idle_cpu_pct(
    browser: Browser, server: ServerProcess, shuttle: ScriptedShuttle, seconds: float
) -> float:
    """Of one core, by all processes of the browser, while a ride's page is open and its shuttle stands."""
    shuttle.speed_mps = 0.0
    context = browser.new_context(**PHONE)
    page = context.new_page()
    ends = [stop["stop_id"] for stop in server.http.get("/stops").json()[:2]]
    ride = server.change("POST", "/rides", {"from_stop": ends[0], "to_stop": ends[1]})
    page.goto(f"{server.origin}/#ride={ride['token']}")
    expect(page.locator("canvas")).to_be_visible(timeout=_TICKET_WITHIN_MS)
    page.wait_for_timeout(_SETTLE_MS)
    before_s, begun_s = _cpu_s(browser), time.perf_counter()
    page.wait_for_timeout(1000.0 * seconds)
    used_s, wall_s = _cpu_s(browser) - before_s, time.perf_counter() - begun_s
    _cancel(page, server)
    context.close()
    return 100.0 * used_s / wall_s


def _cpu_s(browser: Browser) -> float:
    session = browser.new_browser_cdp_session()
    processes = session.send("SystemInfo.getProcessInfo")["processInfo"]
    session.detach()
    return float(sum(process["cpuTime"] for process in processes))


def _cancel(page: Page, server: ServerProcess) -> None:
    token = page.url.partition("#ride=")[2]
    server.change("POST", f"/rides/{token}/cancel")
