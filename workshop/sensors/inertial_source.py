"""A VectorNav's bytes, checked sample by sample."""

import numpy as np

from vehicle_agent.receivers.vectornav import STANDARD_GRAVITY_MPS2, VectorNav
from workshop.sensors.source_report import Arrivals, SourceReport, counted

# The filter of localization wants samples between ticks; no vehicle needs more than a thousand.
_RATE_HZ = (20.0, 1000.0)
# Of the median specific force: vehicles brake and climb, and a scale or an axis that is wrong is farther off.
_GRAVITY_RATIO = 0.1
_FROZEN_MIN = 20


class InertialCheck:
    """One sensor, live."""

    def __init__(self) -> None:
        self._sensor, self._arrivals = VectorNav(), Arrivals()
        self._forces: list[np.ndarray] = []
        self._solutions = 0
        self._bytes = 0

    def add(self, arrived_ns: int, data: bytes) -> None:
        self._bytes += len(data)
        readings, solutions = self._sensor.add(arrived_ns, data)
        for reading in readings:
            self._arrivals.add(arrived_ns)
            self._forces.append(reading.accel_sensor_mps2)
        self._solutions += len(solutions)

    def report(self, name: str) -> SourceReport:
        clock, latency_ms = self._arrivals.clock()
        findings = self._arrivals.findings(*_RATE_HZ)
        if self._bytes and not self._forces:
            findings = [f"no_samples: {self._bytes} bytes; set a binary output with acceleration and rates"]
        if self._forces:
            findings += self._of_forces(np.array(self._forces))
        findings += counted(self._sensor.refused)
        what = "VectorNav" if not self._solutions else f"VectorNav, {self._solutions} positions"
        return SourceReport(
            name, what, len(self._forces), self._arrivals.rate_hz, latency_ms, clock, tuple(findings)
        )

    def _of_forces(self, forces: np.ndarray) -> list[str]:
        sizes = np.linalg.norm(forces, axis=1)
        if not np.isfinite(sizes).all():
            return [f"not_finite: {int((~np.isfinite(sizes)).sum())} of {len(sizes)} samples"]
        found = []
        usual_mps2 = float(np.median(sizes))
        if abs(usual_mps2 / STANDARD_GRAVITY_MPS2 - 1.0) > _GRAVITY_RATIO:
            found.append(f"gravity: {usual_mps2:.2f} m/s2 where {STANDARD_GRAVITY_MPS2:.2f} are due")
        if len(forces) >= _FROZEN_MIN and (forces == forces[0]).all():
            found.append(f"frozen: {len(forces)} equal samples")
        return found
