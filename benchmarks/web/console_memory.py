"""How much memory a console keeps after a working day: eight hours of messages, played as fast as it takes them."""

from playwright.sync_api import Browser, expect

from benchmarks.web.console_frames import DESKTOP, fleet_script
from tests.e2e.operator import sign_in
from tests.e2e.server_process import ServerProcess

HOURS = 8.0
_WARM_UP_MESSAGES = 3_000
# So many messages between two turns of the page's loop, in which it draws.
_AT_ONCE = 25
_MB = 1e6


def heap_growth_mb(browser: Browser, server: ServerProcess, vehicles: int, hours: float = HOURS) -> float:
    """Of the page's JavaScript heap, after collecting garbage, between an early moment and the end."""
    context = browser.new_context(**DESKTOP)
    context.add_init_script(fleet_script(vehicles))
    page = context.new_page()
    page.set_default_timeout(590_000)
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(f"{server.origin}/console")
    sign_in(page)
    expect(page.get_by_text("Shuttle 1", exact=True).first).to_be_visible(timeout=60_000)
    tools = context.new_cdp_session(page)
    tools.send("HeapProfiler.enable")

    def heap_mb() -> float:
        for _ in range(2):
            tools.send("HeapProfiler.collectGarbage")
        return float(tools.send("Runtime.getHeapUsage")["usedSize"]) / _MB

    play = "([count, at_once]) => window.__fleet_socket.play(count, at_once)"
    page.evaluate(play, [_WARM_UP_MESSAGES, _AT_ONCE])
    before_mb = heap_mb()
    page.evaluate(play, [round(hours * 3600.0 * 5.0), _AT_ONCE])
    after_mb = heap_mb()
    context.close()
    if errors:
        raise RuntimeError(f"the console failed while it was measured: {errors[0]}")
    return after_mb - before_mb
