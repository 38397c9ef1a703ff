"""Notices of a ride: asked for on the ticket, sent to a push service, shown by the service worker.

A browser in a test reaches no push service. So the page gets a subscription at one of our own, and what
arrives there is handed to the service worker as the browser would.
"""

import asyncio
import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.passenger import book, cancel
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess
from tests.server.push_service import PushService, serving

pytestmark = [pytest.mark.browser, pytest.mark.real]

WITHIN_S = 45.0
SUBSCRIBED = """
const subscription = { endpoint: %s, toJSON: () => (%s) };
PushManager.prototype.subscribe = async ({ applicationServerKey }) => {
  if (applicationServerKey.length !== 87) throw new DOMException("no key", "AbortError");
  return subscription;
};
PushManager.prototype.getSubscription = async () => subscription;
"""
SHOWN = """async () => (await (await navigator.serviceWorker.ready).getNotifications())
.map(({ title, lang, data }) => ({ title, lang, data }))"""


@contextmanager
def a_push_service() -> Iterator[PushService]:
    service, loop, ready = PushService(), asyncio.new_event_loop(), threading.Event()
    ended = asyncio.Event()

    async def run() -> None:
        async with serving(service):
            ready.set()
            await ended.wait()

    thread = threading.Thread(target=lambda: loop.run_until_complete(run()), daemon=True)
    thread.start()
    assert ready.wait(WITHIN_S)
    try:
        yield service
    finally:
        loop.call_soon_threadsafe(ended.set)
        thread.join(WITHIN_S)
        loop.close()


def subscribe_at(page: Page, service: PushService) -> None:
    """The page's browser subscribes at this push service from the next load on."""
    wish = service.browser.subscription(service.endpoint)
    told = {"endpoint": wish["endpoint"], "keys": {"p256dh": wish["p256dh"], "auth": wish["auth"]}}
    page.add_init_script(SUBSCRIBED % (json.dumps(service.endpoint), json.dumps(told)))


def arrived(page: Page, service: PushService) -> str:
    """The only message, as the browser hands it to the service worker."""
    until_s = time.monotonic() + WITHIN_S
    while not service.notices:
        assert time.monotonic() < until_s, "no message came"
        page.wait_for_timeout(100)
    return json.dumps(service.notices[0])


def deliver(page: Page, server: ServerProcess, message: str) -> None:
    browser = page.context.new_cdp_session(page)
    found: list[str] = []
    browser.on(
        "ServiceWorker.workerRegistrationUpdated",
        lambda event: found.extend(one["registrationId"] for one in event["registrations"]),
    )
    browser.send("ServiceWorker.enable")
    page.wait_for_timeout(200)
    address = {"origin": server.origin, "registrationId": found[0]}
    browser.send("ServiceWorker.deliverPushMessage", address | {"data": message})
    browser.detach()


def await_shown(page: Page, title: str) -> dict[str, str]:
    """The one notice that is shown begins so."""
    until_s = time.monotonic() + WITHIN_S
    shown: list[dict[str, str]] = []
    while not (len(shown) == 1 and shown[0]["title"].startswith(title)):
        assert time.monotonic() < until_s, f"shown: {shown}"
        page.wait_for_timeout(100)
        shown = page.evaluate(SHOWN)
    return shown[0]


def test_a_passenger_who_asked_is_told_by_the_browser_that_the_ride_was_cancelled(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    shuttle.speed_mps = 0.0
    with a_push_service() as service:
        page = open_page("/", **PHONE, service_workers="allow", permissions=["notifications"])
        subscribe_at(page, service)
        page.reload()
        book(page, "Main Library", "Gymnasium")
        page.get_by_role("button", name="Tell me when the shuttle is near").click()
        told = page.get_by_text("You will be told when the shuttle is near")
        expect(told).to_be_visible()
        page.reload()
        expect(told).to_be_visible()
        token = page.url.partition("=")[2]
        ride_id = server.http.get(f"/rides/{token}").json()["ride_id"]
        server.change("POST", f"/rides/id/{ride_id}/cancel")
        deliver(page, server, arrived(page, service))
        shown = await_shown(page, "Your ride was cancelled")
        assert shown["data"] == f"/#ride={token}", "a tap leads to the ticket"


def test_a_passenger_can_stop_it_and_one_who_forbids_notices_reads_how_to_allow_them(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    shuttle.speed_mps = 0.0
    with a_push_service() as service:
        page = open_page("/", **PHONE, service_workers="allow", permissions=["notifications"])
        subscribe_at(page, service)
        page.reload()
        book(page, "Main Library", "Gymnasium")
        page.get_by_role("button", name="Tell me when the shuttle is near").click()
        page.get_by_role("button", name="Do not tell me").click()
        expect(page.get_by_role("button", name="Tell me when the shuttle is near")).to_be_enabled()
        page.context.clear_permissions()
        page.reload()
        page.get_by_role("button", name="Tell me when the shuttle is near").click()
        expect(page.get_by_text("allow notifications for this page")).to_be_visible()
        cancel(page)
