"""How soon the console shows what a vehicle reports: from the vehicle's frame to the painted page.

The vehicle, the server and the browser run on this machine and read one clock.
"""

import time
from dataclasses import dataclass

import numpy as np
from playwright.sync_api import Browser, Page, expect

from benchmarks.web.console_frames import DESKTOP
from contract.wire.messages import ModeChanged
from tests.e2e.operator import sign_in
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess
from vehicle_agent.link.bridge import TickUpdate

SHOWN = "Emergency stop"
SETTLED_MS = 600
# Resolves with the time of the first frame that is painted with the text: the callback after the next frame runs
# when that one is on its way to the screen.
_PAINTED = """(text) => new Promise((resolve) => {
  const look = () => {
    if (!document.body.innerText.includes(text)) return false;
    observer.disconnect();
    requestAnimationFrame(() => requestAnimationFrame(() => resolve(Date.now())));
    return true;
  };
  const observer = new MutationObserver(look);
  observer.observe(document.body, { subtree: true, childList: true, characterData: true });
  look();
})"""


@dataclass(frozen=True, slots=True)
class EventToPixel:
    p50_ms: float
    p95_ms: float


def event_to_pixel(
    browser: Browser, server: ServerProcess, shuttle: ScriptedShuttle, events: int = 20
) -> EventToPixel:
    """A shuttle stops with a fault, again and again, and is resumed."""
    sent_ms: list[float] = []
    _note_sending(shuttle, sent_ms)
    context = browser.new_context(**DESKTOP)
    page = context.new_page()
    page.goto(f"{server.origin}/console")
    sign_in(page)
    expect(page.get_by_text("Shuttle 1", exact=True).first).to_be_visible(timeout=60_000)
    found = [_one_ms(page, server, shuttle, sent_ms) for _ in range(events)]
    context.close()
    return EventToPixel(float(np.percentile(found, 50)), float(np.percentile(found, 95)))


def _one_ms(page: Page, server: ServerProcess, shuttle: ScriptedShuttle, sent_ms: list[float]) -> float:
    expect(page.get_by_text(SHOWN)).to_have_count(0, timeout=20_000)
    # The resume is told before the shuttle's next status, which for a moment says the stop again.
    page.wait_for_timeout(SETTLED_MS)
    expect(page.get_by_text(SHOWN)).to_have_count(0, timeout=20_000)
    sent_ms.clear()
    page.evaluate(f"void (window.__painted = ({_PAINTED})({SHOWN!r}))")
    shuttle.stop_with_fault("lidar_blind")
    painted_ms = float(page.evaluate("window.__painted"))
    for incident in server.http.get("/incidents").json():
        server.change("POST", f"/incidents/{incident['incident_id']}/close")
    server.change("POST", f"/vehicles/{shuttle.vehicle_id}/resume")
    server.await_vehicle(shuttle.vehicle_id, held=False)
    return painted_ms - sent_ms[0]


def _note_sending(shuttle: ScriptedShuttle, sent_ms: list[float]) -> None:
    """Notes when the link gets an event of a stop, before it writes and sends it."""
    desk = shuttle._desk
    pass_on = desk.process_update

    def noted(update: TickUpdate, now_ns: int) -> None:
        if any(isinstance(e, ModeChanged) and e.mode == "minimal_risk" for e in update.events):
            sent_ms.append(time.time() * 1000.0)
        pass_on(update, now_ns)

    desk.process_update = noted  # type: ignore[method-assign]
