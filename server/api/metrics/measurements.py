"""What the server measures of itself, in a registry of its own: two servers in one process do not meet."""

from collections.abc import Iterable

from prometheus_client import CollectorRegistry, Histogram, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from server.fleet.hub import Hub
from server.supervision.supervisor import Supervisor
from server.usecases.ports.clock_and_ids import Clock

# Bookings are answered in tens of milliseconds, a page's first map in some hundreds.
_BUCKETS_S = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0)


class Measurements:
    """The registry, and the histogram that every HTTP request is entered in."""

    def __init__(self, clock: Clock, hub: Hub, supervisor: Supervisor) -> None:
        self._registry = CollectorRegistry(auto_describe=False)
        self.requests = Histogram(
            "campusloop_http_request_duration_seconds",
            "From the head of a request to the end of its answer. route: the template, never the path itself",
            ("method", "route", "status"),
            buckets=_BUCKETS_S,
            registry=self._registry,
        )
        self._registry.register(_PresentState(clock, hub, supervisor))

    def text(self) -> bytes:
        """Everything in the Prometheus text format."""
        return generate_latest(self._registry)


class _PresentState(Collector):
    """What is read at the moment of the question."""

    def __init__(self, clock: Clock, hub: Hub, supervisor: Supervisor) -> None:
        self._clock, self._hub, self._supervisor = clock, hub, supervisor

    def collect(self) -> Iterable[Metric]:
        connected = GaugeMetricFamily(
            "campusloop_vehicles_connected", "Vehicles with an open session on this server"
        )
        connected.add_metric((), len(self._hub.connected()))
        yield connected
        yield from self._tasks()

    def _tasks(self) -> Iterable[Metric]:
        now = self._clock.now()
        works = GaugeMetricFamily(
            "campusloop_task_works", "1 if the last cycle of a standing task was good", labels=["task"]
        )
        failures = CounterMetricFamily(
            "campusloop_task_failures", "Failed cycles and inputs of a standing task", labels=["task"]
        )
        good = GaugeMetricFamily(
            "campusloop_task_last_good_timestamp_seconds", "When a cycle ended well last", labels=["task"]
        )
        for task in self._supervisor.health():
            works.add_metric((task.name,), float(task.failures == 0 and not task.is_late(now)))
            failures.add_metric((task.name,), task.failures_total)
            if task.last_good_at is not None:
                good.add_metric((task.name,), task.last_good_at.timestamp())
        yield from (works, failures, good)
