"""How many frames a second the console shows with a large fleet, drawn in software."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Browser, expect

from contract.geometry import Array
from tests.e2e.operator import sign_in
from tests.e2e.server_process import ServerProcess

HZ = 5
CYCLE_S = 4
WARM_UP_MS = 4_000
DESKTOP: dict[str, Any] = {"viewport": {"width": 1440, "height": 900}}
_FLEET = Path(__file__).with_name("fleet_socket.js")

# The times between two frames, in milliseconds, for so long.
_FRAMES = """(measured_ms) => new Promise((resolve) => {
  const times = [];
  const note = (now) => {
    times.push(now);
    if (now - times[0] < measured_ms) requestAnimationFrame(note);
    else resolve(times.slice(1).map((time, index) => time - times[index]));
  };
  requestAnimationFrame(note);
})"""


@dataclass(frozen=True, slots=True)
class Frames:
    """fps_median: of whole seconds; frame_p95_ms: the time between two frames."""

    vehicles: int
    fps_median: float
    frame_p95_ms: float
    nodes: int


def fleet_script(vehicles: int) -> str:
    """For every new document of a browser context: the live websocket is played within the page."""
    return f"({_FLEET.read_text()})({vehicles}, {HZ}, {CYCLE_S});"


def measure_console(
    browser: Browser, server: ServerProcess, vehicles: int, seconds: float, screenshots: Path | None
) -> Frames:
    """The live page with the whole fleet on the map and in the list.

    The live websocket is played within the page, so that neither the server nor a thousand vehicles take time
    from the browser; the page receives, parses, reduces and draws as always.
    """
    context = browser.new_context(**DESKTOP)
    context.add_init_script(fleet_script(vehicles))
    page = context.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(f"{server.origin}/console")
    sign_in(page)
    expect(page.get_by_text("Shuttle 1", exact=True).first).to_be_visible(timeout=60_000)
    page.wait_for_timeout(WARM_UP_MS)
    between_ms = np.array(page.evaluate(_FRAMES, 1000.0 * seconds))
    nodes = int(page.evaluate("document.getElementsByTagName('*').length"))
    if screenshots is not None:
        page.screenshot(path=screenshots / f"console-{vehicles}-vehicles.png")
    context.close()
    if errors:
        raise RuntimeError(f"the console failed while it was measured: {errors[0]}")
    return Frames(
        vehicles, _median_of_seconds(between_ms), float(np.percentile(between_ms, 95.0)), nodes
    )


def _median_of_seconds(between_ms: Array) -> float:
    """Frames in each whole second; their median."""
    at_s = np.cumsum(between_ms) / 1000.0
    counts = np.bincount(at_s.astype(np.int64))[: int(at_s[-1])]
    return float(np.median(counts))
