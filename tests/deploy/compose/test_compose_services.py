"""docker-compose.yml brought up, used through its proxy, and its servers replaced one by one."""

import json
import os
import shutil
import signal
import ssl
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.deploy.compose.running_services import FOLDER, RunningServices, services

pytestmark = [
    pytest.mark.faults,
    pytest.mark.skipif(os.getuid() != 0, reason="the proxy's ports are below 1024"),
    pytest.mark.skipif(
        not all(shutil.which(program) for program in ("caddy", "prometheus")),
        reason="Caddy or Prometheus is not installed: scripts/services",
    ),
]
STARTS_WITHIN_S = 90.0


@pytest.fixture(scope="module")
def campus() -> Iterator[RunningServices]:
    """Everything in the file but Grafana, which is no package."""
    with tempfile.TemporaryDirectory(prefix="campusloop-compose-", dir="/tmp") as folder:
        Path(folder).chmod(0o755)
        with services(Path(folder), SHUTTLES="1") as running:
            for name in ("postgres", "nats"):
                running.start(name)
            at = running.addresses
            until(running, "nats", lambda: answers(f"http://{at['nats']}:8222/healthz"))
            for name in ("server-1", "server-2"):
                running.start(name)
            for name in ("server-1", "server-2"):
                until(running, name, lambda name=name: answers(f"http://{at[name]}:8080/api/v1/ready"))  # type: ignore[misc]
            running.start("proxy")
            until(running, "proxy", lambda: answers(f"http://{at['proxy']}:8081/api/v1/ready"))
            for name in ("prometheus", "shuttles"):
                running.start(name)
            until(running, "prometheus", lambda: answers(f"http://{at['prometheus']}:9090/-/ready"))
            yield running


@pytest.fixture
def browser(campus: RunningServices) -> Iterator[httpx.Client]:
    """A client of the public address, which trusts the proxy's own certificate."""
    root = campus.folder / "volumes" / "proxy-data" / "caddy" / "pki" / "authorities" / "local" / "root.crt"
    with httpx.Client(base_url="https://localhost", verify=ssl.create_default_context(cafile=root)) as client:
        yield client


def answers(url: str) -> bool:
    try:
        return httpx.get(url, timeout=5.0).is_success
    except httpx.TransportError:
        return False


def until(campus: RunningServices, name: str, holds: Callable[[], bool]) -> None:
    """Wait for it. Fails with the log of the service."""
    deadline_s = time.monotonic() + STARTS_WITHIN_S
    while time.monotonic() < deadline_s:
        if holds():
            return
        assert campus.processes[name].poll() is None, campus.log(name)
        time.sleep(0.25)
    pytest.fail(f"{name} was not there in {STARTS_WITHIN_S:.0f} s:\n{campus.log(name)}")


def operator_of(campus: RunningServices, client: httpx.Client) -> None:
    answer = client.post(
        "/api/v1/session", json={"name": "operator", "password": campus.secret("operator_password")}
    )
    assert answer.status_code in (200, 201), answer.text


def a_booking(client: httpx.Client) -> httpx.Response:
    stops = [stop["stop_id"] for stop in client.get("/api/v1/stops").json()]
    return client.post("/api/v1/rides", json={"from_stop": stops[0], "to_stop": stops[-1]})


def test_a_shuttle_drives_and_a_ride_is_booked_through_the_proxy(
    campus: RunningServices, browser: httpx.Client
) -> None:
    operator_of(campus, browser)

    def drives() -> bool:
        vehicles = browser.get("/api/v1/vehicles").json()
        return len(vehicles) == 1 and vehicles[0]["connected"] and not vehicles[0]["held"]

    until(campus, "shuttles", drives)
    booked = a_booking(browser)
    assert booked.status_code == 201, booked.text
    assert booked.json()["promise"] is not None
    assert "<html" in browser.get("/").text


def test_the_measurements_are_not_for_the_outside(browser: httpx.Client) -> None:
    assert browser.get("/api/v1/metrics").status_code == 404


def test_servers_that_are_replaced_one_by_one_lose_no_booking(
    campus: RunningServices, browser: httpx.Client
) -> None:
    answered: list[int] = []
    stopped = threading.Event()

    def book() -> None:
        while not stopped.wait(0.5):
            answered.append(a_booking(browser).status_code)

    booking = threading.Thread(target=book)
    booking.start()
    try:
        for name in ("server-1", "server-2"):
            # After its work is done, uvicorn ends by the signal that it was sent.
            assert campus.stop(name) in (0, -signal.SIGTERM), campus.log(name)
            time.sleep(3.0)
            campus.start(name)
            url = f"http://{campus.addresses[name]}:8080/api/v1/ready"
            until(campus, name, lambda url=url: answers(url))  # type: ignore[misc]
            # The proxy asks for it every two seconds.
            time.sleep(3.0)
    finally:
        stopped.set()
        booking.join(timeout=60.0)
    assert len(answered) > 10
    # A request may be refused because no seat is free; it may not fail.
    assert not [status for status in answered if status >= 500 or status == 0], answered
    operator_of(campus, browser)
    until(campus, "shuttles", lambda: browser.get("/api/v1/vehicles").json()[0]["connected"])


def test_every_panel_of_the_dashboard_has_an_answer(campus: RunningServices) -> None:
    origin = f"http://{campus.addresses['prometheus']}:9090"

    def asked(expression: str) -> list[dict[str, Any]]:
        answer = httpx.get(f"{origin}/api/v1/query", params={"query": expression}).json()
        assert answer["status"] == "success", (expression, answer)
        result: list[dict[str, Any]] = answer["data"]["result"]
        return result

    until(campus, "prometheus", lambda: [one["value"][1] for one in asked("up")] == ["1", "1"])
    dashboard = json.loads((FOLDER / "grafana" / "dashboards" / "campusloop.json").read_text())
    expressions = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
    assert [expression for expression in expressions if not asked(expression)] == []
