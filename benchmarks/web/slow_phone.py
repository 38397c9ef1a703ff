"""The passenger's first load on a slow phone: largest contentful paint, by the DevTools protocol.

The network is shaped and the processor slowed by Chromium itself, as Lighthouse's mobile profile does: 1.6 Mbit/s
down, 750 kbit/s up, 150 ms for each round trip, a quarter of the speed of this machine.
"""

from statistics import median

from playwright.sync_api import Browser

from benchmarks.web.passenger import PHONE
from tests.e2e.server_process import ServerProcess

DOWN_BPS, UP_BPS = 1_600_000, 750_000
RTT_MS, CPU_SLOWDOWN = 150, 4
_SETTLE_MS = 6_000
# The last candidate before the first input is the largest contentful paint (W3C, Largest Contentful Paint).
_OBSERVE = """
  window.__lcp = [];
  new PerformanceObserver((list) => {
    for (const entry of list.getEntries()) window.__lcp.push([entry.startTime, entry.element?.tagName ?? ""]);
  }).observe({ type: "largest-contentful-paint", buffered: true });
"""


def largest_paint_ms(browser: Browser, server: ServerProcess, loads: int = 5) -> float:
    """The median of several first loads, each of a browser that has nothing of the page yet."""
    return median(_one_load_ms(browser, server) for _ in range(loads))


def _one_load_ms(browser: Browser, server: ServerProcess) -> float:
    context = browser.new_context(**PHONE)
    page = context.new_page()
    page.add_init_script(_OBSERVE)
    tools = context.new_cdp_session(page)
    tools.send("Network.enable")
    tools.send(
        "Network.emulateNetworkConditions",
        {
            "offline": False,
            "latency": RTT_MS,
            "downloadThroughput": DOWN_BPS / 8,
            "uploadThroughput": UP_BPS / 8,
        },
    )
    tools.send("Emulation.setCPUThrottlingRate", {"rate": CPU_SLOWDOWN})
    page.goto(server.origin)
    page.wait_for_timeout(_SETTLE_MS)
    found = page.evaluate("window.__lcp")
    context.close()
    if not found:
        raise RuntimeError("the page has painted nothing that counts")
    return float(found[-1][0])
