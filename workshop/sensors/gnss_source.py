"""A GNSS receiver's bytes, checked fix by fix."""

import math

from vehicle_agent.receivers.gnss_receiver import GnssReceiver
from vehicle_agent.receivers.solutions import Solution
from workshop.sensors.source_report import Arrivals, SourceReport, counted

_RATE_HZ = (0.9, 50.0)
_STD_M_MAX = 1.0
_SPEED_MPS_MAX = 60.0
# What a fix may be off the way that the speeds before it give, besides three deviations.
_JUMP_M = 3.0
_M_PER_DEG = 111_200.0


class GnssCheck:
    """One receiver, live or recorded."""

    def __init__(self) -> None:
        self._receiver, self._arrivals = GnssReceiver(), Arrivals()
        self._before: tuple[int, Solution] | None = None
        self._counts: dict[str, int] = {}
        self._bytes = 0

    def add(self, arrived_ns: int | None, data: bytes) -> None:
        """arrived_ns: UTC; None for a file, which does not say it: the receiver's own times are taken."""
        self._bytes += len(data)
        before = self._receiver.latest
        self._receiver.add(arrived_ns or 0, data)
        solution = self._receiver.latest
        if solution is None or solution is before:
            return
        if arrived_ns is None:
            if solution.utc_ns is None:
                self._count("no_date")
                return
            self._arrivals.add(solution.utc_ns)
        else:
            self._arrivals.add(arrived_ns, solution.utc_ns)
        if solution.position_std_m > _STD_M_MAX:
            self._count("poor")
        if solution.speed_mps > _SPEED_MPS_MAX:
            self._count("too_fast")
        self._check_jump(self._arrivals.arrived_ns[-1], solution)

    def report(self, name: str) -> SourceReport:
        receiver = self._receiver
        clock, latency_ms = self._arrivals.clock()
        findings = self._arrivals.findings(*_RATE_HZ)
        if self._bytes and not self._arrivals.arrived_ns:
            findings = [f"no_position: {self._bytes} bytes, {receiver.other} messages of other kinds"]
        findings += counted({**receiver.refused, **self._counts, "bad_frames": receiver.frames.bad_checksums})
        return SourceReport(
            name, "GNSS receiver", len(self._arrivals.arrived_ns), self._arrivals.rate_hz, latency_ms, clock,
            tuple(findings),
        )  # fmt: skip

    def _check_jump(self, now_ns: int, solution: Solution) -> None:
        if self._before is not None:
            then_ns, then = self._before
            north_m = _M_PER_DEG * (solution.latitude_deg - then.latitude_deg)
            east_m = _M_PER_DEG * (solution.longitude_deg - then.longitude_deg)
            east_m *= math.cos(math.radians(then.latitude_deg))
            reach_m = max(then.speed_mps, solution.speed_mps) * abs(now_ns - then_ns) * 1e-9
            if math.hypot(north_m, east_m) > reach_m + _JUMP_M + 3.0 * solution.position_std_m:
                self._count("jump")
        self._before = (now_ns, solution)

    def _count(self, code: str) -> None:
        self._counts[code] = self._counts.get(code, 0) + 1
