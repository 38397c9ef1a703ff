"""How soon the replay of a fleet's day is there, and how soon it shows another moment."""

import random
import tempfile
import time
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, expect

from benchmarks.web.console_frames import DESKTOP
from benchmarks.web.fleet_day import write_day
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from tests.e2e.operator import sign_in
from tests.e2e.server_process import CAMPUS_MAP, ServerProcess

SEEKS = 40
HOURS = 24.0
# From the slider's event until the positions of that moment have been loaded and drawn.
_SEEK = """(share) => new Promise((resolve) => {
  const range = document.querySelector(".timeline input[type=range]");
  const begun = performance.now();
  range.value = Number(range.min) + (range.max - range.min) * share;
  range.dispatchEvent(new Event("input", { bubbles: true }));
  const look = () => {
    const waits = document.body.innerText.includes("Loading the positions");
    if (waits) requestAnimationFrame(look);
    else requestAnimationFrame(() => resolve(performance.now() - begun));
  };
  requestAnimationFrame(look);
})"""


@dataclass(frozen=True, slots=True)
class Replay:
    """Of a day of `positions` stored positions; seeks go to random moments of it that were not loaded before."""

    positions: int
    open_s: float
    seek_p50_ms: float
    seek_p95_ms: float


def measure_replay(browser: Browser, vehicles: int, seed: int, screenshots: Path | None) -> Replay:
    """A server of its own with yesterday in its database. `open_s` is from the click until the fleet is drawn."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        network = RoadNetwork(load_map(CAMPUS_MAP))
        start = datetime.now(UTC) - timedelta(hours=HOURS)
        positions = write_day(folder / "campusloop.db", network, vehicles, start, HOURS)
        with ServerProcess(folder) as server:
            page = browser.new_context(**DESKTOP).new_page()
            start_ms, seconds = round(start.timestamp() * 1000), round(HOURS * 3600)
            page.goto(f"{server.origin}/console#/runs")
            sign_in(page)
            expect(page.get_by_role("button", name="Replay the fleet")).to_be_visible()
            begun = time.perf_counter()
            middle_ms = start_ms + 500 * seconds
            page.evaluate(f"location.hash = '#/runs/@fleet/{start_ms}/{seconds}/{middle_ms}'")
            fleet = page.get_by_role("region", name="Vehicles")
            expect(fleet.locator(".row", has_text="Driving").first).to_be_visible(timeout=60_000)
            expect(page.get_by_role("region", name="What happened").locator("li").first).to_be_visible()
            open_s = time.perf_counter() - begun
            rng = random.Random(seed)
            times_ms = np.array([page.evaluate(_SEEK, rng.random()) for _ in range(SEEKS)])
            if screenshots is not None:
                page.screenshot(path=screenshots / "fleet-replay.png")
            page.context.close()
    return Replay(
        positions,
        open_s,
        float(np.percentile(times_ms, 50.0)),
        float(np.percentile(times_ms, 95.0)),
    )
