import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from tests.e2e.chromium import LAUNCH_FLAGS, chromium_path
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ROOT, ServerProcess

# Far more than it takes: no test is timed, and a slow machine is no failure.
WITHIN_MS = 45_000
expect.set_options(timeout=WITHIN_MS)

OpenPage = Callable[..., Page]

# The second is said of what the service worker could answer neither itself nor by the server, the third of an
# attempt at the live view that was under way when the network came back.
NO_CONNECTION = (
    "net::ERR_INTERNET_DISCONNECTED",
    "net::ERR_FAILED",
    "WebSocket is closed before the connection is established",
)

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
DESKTOP = {"viewport": {"width": 1440, "height": 900}}


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium_path(), args=list(LAUNCH_FLAGS))
        yield started
        started.close()


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    assert (ROOT / "web" / "dist" / "index.html").exists(), "the web pages are not built: run `make web`"
    with ServerProcess(tmp_path_factory.mktemp("server")) as running:
        yield running


@pytest.fixture(scope="session")
def enrolled_shuttle(server: ServerProcess) -> ScriptedShuttle:
    return server.add_shuttle("shuttle-1", "Shuttle 1", resting_place=0)


@pytest.fixture
def shuttle(server: ServerProcess, enrolled_shuttle: ScriptedShuttle) -> Iterator[ScriptedShuttle]:
    """The one shuttle of all tests: at its usual speed and without the rides of the test before."""
    speed_mps = enrolled_shuttle.speed_mps
    yield enrolled_shuttle
    enrolled_shuttle.speed_mps = speed_mps
    enrolled_shuttle.cameras, enrolled_shuttle.obstacle_m = {}, None
    server.cancel_rides()


@pytest.fixture
def open_page(browser: Browser, server: ServerProcess) -> Iterator[OpenPage]:
    """open_page(path, **context options): a page that may say nothing on the browser's console.

    Answers to deliberate mistakes are logged by the browser as failed loads; `allowed` names their statuses,
    and `goes_offline` says that requests without a connection are meant.
    """
    contexts = []
    complaints: list[str] = []

    def opened(
        path: str, allowed: tuple[int, ...] = (), *, goes_offline: bool = False, **options: Any
    ) -> Page:
        # A service worker's requests pass by the routes that tests set; those of the worker itself allow it.
        usual: dict[str, Any] = {"locale": "en-GB", "service_workers": "block"} | DESKTOP
        context = browser.new_context(**(usual | options))
        context.set_default_timeout(WITHIN_MS)
        contexts.append(context)
        page = context.new_page()

        def heard(kind: str, text: str) -> None:
            is_meant = any(f"status of {code}" in text for code in allowed)
            is_meant = is_meant or (goes_offline and any(error in text for error in NO_CONNECTION))
            is_meant = is_meant or "Service Worker registration blocked by Playwright" in text
            if kind in ("error", "warning") and not is_meant:
                complaints.append(text)

        page.on("console", lambda message: heard(message.type, message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(f"{server.origin}{path}")
        return page

    yield opened
    for context in contexts:
        context.close()
    assert complaints == []


@pytest.fixture
def screenshots() -> Path | None:
    """Where to leave pictures to look at: CAMPUSLOOP_SCREENSHOTS, if it is set."""
    folder = os.environ.get("CAMPUSLOOP_SCREENSHOTS")
    if folder is None:
        return None
    Path(folder).mkdir(parents=True, exist_ok=True)
    return Path(folder)
