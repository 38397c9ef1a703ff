"""Run a proof of a lower bound until it is closed or its time is up. The proof counts; this file owns the clock."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from server.dispatch.bound.network import network_of
from server.dispatch.bound.proof import Limits, Progress, prove
from server.dispatch.instance import Instance


@dataclass(frozen=True, slots=True)
class BoundRun:
    """What was proven, and the time that it took."""

    proven: Progress
    wall_s: float
    cpu_s: float

    @property
    def gap_pct(self) -> float | None:
        """Between the bound and the best solution found, None without one."""
        if not self.proven.solution:
            return None
        return 100.0 * max(0.0, self.proven.upper - self.proven.bound) / self.proven.upper


def run_bound(
    instance: Instance,
    seconds: float,
    upper: float = float("inf"),
    watch: Callable[[Progress], None] = lambda _: None,
) -> BoundRun:
    """Slices of the proof until the deadline; one that has begun is finished. Raises InstanceBroken, TooManyEvents."""
    began_wall_s, began_cpu_s = time.monotonic(), time.process_time()
    steps = prove(network_of(instance), Limits(), upper)
    proven = next(steps)
    for proven in steps:
        watch(proven)
        if time.monotonic() - began_wall_s >= seconds:
            break
    return BoundRun(proven, time.monotonic() - began_wall_s, time.process_time() - began_cpu_s)
