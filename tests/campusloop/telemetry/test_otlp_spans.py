"""A real server and a real agent send the spans of a ride to one collector, as one trace."""

import asyncio
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import httpx
import pytest

from campusloop.clients.operator_client import OperatorClient
from campusloop.telemetry import otlp_spans
from campusloop.telemetry.otlp_spans import TracingUnavailable, span_source
from contract.tracing import NO_SPANS, trace_id_of
from tests.campusloop.telemetry.running_commands import free_port, running
from tests.campusloop.virtual.test_ride_traces import STEPS
from tests.faults.real_campus import nearest_pair
from tests.server.api.server_under_test import MAPS, PASSWORD, snow_lion

MAP = str(MAPS / "snow-lion" / "map.json")
WITHIN_S = 120.0
# Slower than the server's limit of bookings.
AGAIN_AFTER_S = 2.5


class Collector(ThreadingHTTPServer):
    """spans: trace id, name, process."""

    def __init__(self) -> None:
        self.spans: list[tuple[str, str, str]] = []
        super().__init__(("127.0.0.1", 0), _Handler)

    def take(self, body: bytes) -> None:
        from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest

        for resource in ExportTraceServiceRequest.FromString(body).resource_spans:
            attributes = {one.key: one.value.string_value for one in resource.resource.attributes}
            for scope in resource.scope_spans:
                for span in scope.spans:
                    process = attributes["service.instance.id"]
                    self.spans.append((span.trace_id.hex(), span.name, process))


class _Handler(BaseHTTPRequestHandler):
    server: Collector

    def do_POST(self) -> None:
        assert self.path == "/v1/traces"
        self.server.take(self.rfile.read(int(self.headers["content-length"])))
        self.send_response(200)
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Nothing is printed."""


@contextmanager
def collecting() -> Iterator[Collector]:
    with Collector() as collector:
        thread = threading.Thread(target=collector.serve_forever)
        thread.start()
        try:
            yield collector
        finally:
            collector.shutdown()
            thread.join()


@pytest.mark.real
@pytest.mark.long
def test_a_ride_of_real_processes_is_one_trace(tmp_path: Path) -> None:
    pytest.importorskip("opentelemetry.sdk", reason="OpenTelemetry is not installed: make tracing")
    origin = f"http://127.0.0.1:{(port := free_port())}"
    shuttles = ("shuttles", "--server", origin, "--count", "1", "--map", MAP, "--folder", str(tmp_path / "s"))
    with collecting() as collector:
        environment = {
            "OTEL_EXPORTER_OTLP_ENDPOINT": f"http://127.0.0.1:{collector.server_port}",
            "OTEL_BSP_SCHEDULE_DELAY": "200",
        }
        with (
            running(tmp_path, "serve", "serve", "--port", str(port), "--map", MAP, environment=environment),
            running(tmp_path, "shuttles", *shuttles, environment=environment),
            httpx.Client(base_url=f"{origin}/api/v1", trust_env=False, timeout=WITHIN_S) as http,
        ):
            ride_id = booked(http, tmp_path)
            named: dict[str, str] = {}
            for _ in range(round(WITHIN_S / 0.2)):
                trace = trace_id_of(ride_id)
                named = {name: process for found, name, process in collector.spans if found == trace}
                if len(named) == len(STEPS):
                    break
                time.sleep(0.2)
    assert sorted(named) == sorted(STEPS), (tmp_path / "s" / "logs" / "link.log").read_text()
    assert {named[name] for name in STEPS[:4]} == {"server"}
    assert {named[name] for name in STEPS[4:]} == {"link"}


def booked(http: httpx.Client, folder: Path) -> str:
    """A ride with a shuttle, as soon as there is one."""
    origin, target = nearest_pair(snow_lion())
    said: dict[str, object] = {}
    for _ in range(round(WITHIN_S / AGAIN_AFTER_S)):
        time.sleep(AGAIN_AFTER_S)
        if "all shuttles drive" not in (folder / "shuttles.log").read_text():
            continue
        said = http.post("/rides", json={"from_stop": origin, "to_stop": target}).json()
        if said.get("state") == "assigned":
            return str(said["ride_id"])
        # A machine that stands still for a second makes every vehicle stop for safety, and stay so until an
        # operator resumes it.
        asyncio.run(resumed(http))
    raise AssertionError((said, http.get("/vehicles").json(), (folder / "shuttles.log").read_text()))


async def resumed(http: httpx.Client) -> None:
    origin = f"{http.base_url.scheme}://{http.base_url.host}:{http.base_url.port}"
    async with httpx.AsyncClient(base_url=origin, trust_env=False, timeout=WITHIN_S) as client:
        operator = OperatorClient(client)
        await operator.sign_in("operator", PASSWORD)
        await operator.command("shuttle-1", "resume")


def test_nothing_is_traced_where_no_collector_is_named() -> None:
    assert span_source({}) is NO_SPANS


def test_a_named_collector_without_the_extra_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(otlp_spans, "find_spec", lambda _: None)
    with pytest.raises(TracingUnavailable, match="make tracing"):
        span_source({"OTEL_EXPORTER_OTLP_ENDPOINT": "http://127.0.0.1:4318"})
