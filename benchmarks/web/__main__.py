"""What people wait for in the pages, in real Chromium against a real server.

    python -m benchmarks.web [--vehicles 1000] [--seconds 10] [--replay-vehicles 50] [--heap-vehicles 20] [--seed 1] [--skip-axe] [--skip-lighthouse] [--screenshots DIR] [--json FILE]

The pages must be built (`make web`). The server is a process of its own with the shipped campus and a
scripted shuttle. The summary:

    first_load_kb   over the wire until a booking is possible: page, scripts, styles, campus and stops
    taps, booking_s the first booking, from the empty page to the ticket, by a script that does not wait
    console_fps     frames in a second (median) of the live page with --vehicles at 5 Hz, drawn in software;
                    the live websocket is played within the page, so that only the page takes time
    frame_p95_ms    the time between two of these frames
    idle_cpu_pct    of a core, all processes of the browser, a ride's page open while its shuttle stands
    replay_open_s   from the click until the fleet's day is drawn: --replay-vehicles, 24 hours, 2 positions a second
    replay_seek_p95_ms  from the slider to the fleet at a moment of the day that was not loaded before
    first_lcp_ms    largest contentful paint of the first load at 1.6 Mbit/s, 150 ms RTT, a quarter of the speed
    event_to_pixel_p50_ms, event_to_pixel_p95_ms  from a vehicle's frame to the console's painted frame
    heap_growth_8h_mb  of the console's JavaScript heap over 8 h of messages of --heap-vehicles, played fast
    bookings_p95_ms  answers at 50 bookings a second on the real server (`benchmarks.bookings`)
    import_s        from a file of OpenStreetMap, uploaded by a script, to the network that the server runs
    lighthouse_performance, lighthouse_accessibility, lighthouse_best_practices, lighthouse_seo  of 100, of the
                    passenger page on a slow phone: medians of three loads (`make lighthouse` installs it)
    axe_violations  rules of axe-core (WCAG 2.2 A and AA, best practice) times states that break them
    axe_states      states of both pages x {en, zh} x {light, dark} x {plain, text at 200 %, reduced motion}
"""

import argparse
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

from benchmarks.reporting.report import Row, RunReport
from benchmarks.web.accessibility import Audit, rows_of
from benchmarks.web.console_frames import measure_console
from benchmarks.web.console_latency import event_to_pixel
from benchmarks.web.console_memory import heap_growth_mb
from benchmarks.web.fleet_replay import measure_replay
from benchmarks.web.lighthouse import CATEGORIES, lighthouse_scores, require_lighthouse
from benchmarks.web.map_import import import_s
from benchmarks.web.passenger import first_booking, first_load_kb, idle_cpu_pct
from benchmarks.web.served_load import booking_p95_ms
from benchmarks.web.slow_phone import largest_paint_ms
from tests.e2e.chromium import LAUNCH_FLAGS, chromium_path
from tests.e2e.server_process import ServerProcess


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--vehicles", type=int, default=1000, help="in the console's fleet")
    parser.add_argument("--seconds", type=float, default=10.0, help="of measuring frames and idleness")
    parser.add_argument("--replay-vehicles", type=int, default=50, help="in the replayed day; 0 leaves it out")
    parser.add_argument("--heap-vehicles", type=int, default=20, help="in the eight hours of the console")
    parser.add_argument("--seed", type=int, default=1, help="of the moments that are looked at")
    parser.add_argument("--skip-axe", action="store_true", help="leave out accessibility (minutes)")
    parser.add_argument("--skip-lighthouse", action="store_true", help="leave out Lighthouse")
    parser.add_argument("--screenshots", type=Path, default=None, help="keep a picture of every state here")
    parser.add_argument("--json", type=Path, default=None)
    arguments = parser.parse_args()
    if arguments.screenshots is not None:
        arguments.screenshots.mkdir(parents=True, exist_ok=True)
    if not arguments.skip_lighthouse:
        require_lighthouse()
    report = RunReport()
    rows, summary = _measure(arguments)
    given = {"vehicles": arguments.vehicles, "seconds": arguments.seconds, "replay_vehicles": arguments.replay_vehicles, "heap_vehicles": arguments.heap_vehicles, "seed": arguments.seed, "skip_axe": arguments.skip_axe, "skip_lighthouse": arguments.skip_lighthouse}
    report.write(arguments.json, "web", given, rows, summary)


def _measure(arguments: argparse.Namespace) -> tuple[list[Row], Row]:
    with tempfile.TemporaryDirectory() as folder, ServerProcess(Path(folder)) as server:
        shuttle = server.add_shuttle("shuttle-1", "Shuttle 1", resting_place=0)
        with _browser() as browser:
            load_kb = first_load_kb(browser, server)
            booking = first_booking(browser, server, arguments.screenshots)
            idle_pct = idle_cpu_pct(browser, server, shuttle, arguments.seconds)
        with _browser() as browser:
            lcp_ms = largest_paint_ms(browser, server)
        scores = dict.fromkeys(CATEGORIES.values()) if arguments.skip_lighthouse else lighthouse_scores(server)
        with _browser() as browser:
            latency = event_to_pixel(browser, server, shuttle)
        with _browser() as browser:
            growth_mb = heap_growth_mb(browser, server, arguments.heap_vehicles)
        with _browser() as browser:
            frames = measure_console(
                browser, server, arguments.vehicles, arguments.seconds, arguments.screenshots
            )
        replay = None
        if arguments.replay_vehicles:
            with _browser() as browser:
                replay = measure_replay(
                    browser, arguments.replay_vehicles, arguments.seed, arguments.screenshots
                )
        with _browser() as browser:
            audit = Audit(browser, server, arguments.screenshots)
            if not arguments.skip_axe:
                audit.run()
    # On a server of its own: no shuttle may be under way on what the import changes.
    with tempfile.TemporaryDirectory() as folder, ServerProcess(Path(folder)) as server:
        imported_s = import_s(server)
    p95_ms = booking_p95_ms(2.0 * arguments.seconds)
    summary: Row = {
        "first_load_kb": load_kb,
        "taps": booking.taps,
        "booking_s": booking.seconds,
        "console_fps": frames.fps_median,
        "frame_p95_ms": frames.frame_p95_ms,
        "console_nodes": frames.nodes,
        "idle_cpu_pct": idle_pct,
        "replay_open_s": None if replay is None else replay.open_s,
        "replay_seek_p50_ms": None if replay is None else replay.seek_p50_ms,
        "replay_seek_p95_ms": None if replay is None else replay.seek_p95_ms,
        "first_lcp_ms": lcp_ms,
        "event_to_pixel_p50_ms": latency.p50_ms,
        "event_to_pixel_p95_ms": latency.p95_ms,
        "heap_growth_8h_mb": growth_mb,
        "bookings_p95_ms": p95_ms,
        "import_s": imported_s,
        **scores,
        "axe_violations": None if arguments.skip_axe else len(audit.violations),
        "axe_states": audit.states,
    }
    return list(rows_of(audit.violations)), summary


@contextmanager
def _browser() -> Iterator[Browser]:
    """One of its own for each measurement: an earlier one's garbage would count in the next."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium_path(), args=list(LAUNCH_FLAGS))
        yield browser
        browser.close()


if __name__ == "__main__":
    main()
