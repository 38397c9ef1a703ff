"""What was seen of one source, and what is wrong with it."""

from dataclasses import dataclass, field

import numpy as np

# A pause of so many usual periods is a gap.
_GAP_PERIODS = 3.0
_GAPS_NAMED = 0.001
# A sensor whose clock differs by less is taken to be set by PPS, PTP or GNSS; the rest is latency.
SYNCHRONISED_NS = 500_000_000


@dataclass(frozen=True, slots=True)
class SourceReport:
    """One line of a check.

    what        model or message type
    messages    whole scans, fixes or messages
    rate_hz     of them; None for fewer than two
    latency_ms  median time from the sensor's stamp to the arrival; None without a common clock
    clock       what the sensor's own clock is
    findings    codes of what is wrong, with numbers; empty for a sound source
    """

    name: str
    what: str
    messages: int
    rate_hz: float | None
    latency_ms: float | None
    clock: str
    findings: tuple[str, ...]


@dataclass(slots=True)
class Arrivals:
    """When messages came, and when their sensors say that they were made (both ns)."""

    arrived_ns: list[int] = field(default_factory=list)
    made_ns: list[int] = field(default_factory=list)

    def add(self, arrived_ns: int, made_ns: int | None = None) -> None:
        self.arrived_ns.append(arrived_ns)
        if made_ns is not None:
            self.made_ns.append(made_ns - arrived_ns)

    @property
    def rate_hz(self) -> float | None:
        """By the median period, so that a pause does not change it."""
        periods = self._periods_ns()
        usual = float(np.median(periods)) if len(periods) else 0.0
        return 1e9 / usual if usual > 0.0 else None

    def clock(self) -> tuple[str, float | None]:
        """(what the sensor's clock is, latency in ms where it is set)."""
        if not self.made_ns:
            return "none", None
        off_ns = float(np.median(self.made_ns))
        if abs(off_ns) < SYNCHRONISED_NS:
            return "set", -1e-6 * off_ns
        return f"off by {1e-9 * off_ns:.1f} s", None

    def findings(self, rate_hz_min: float, rate_hz_max: float) -> list[str]:
        """Of the times alone."""
        if not self.arrived_ns:
            return ["silent"]
        found = []
        rate_hz, periods = self.rate_hz, self._periods_ns()
        if rate_hz is not None and not rate_hz_min <= rate_hz <= rate_hz_max:
            found.append(f"rate: {rate_hz:.2f} Hz, {rate_hz_min:g} to {rate_hz_max:g} expected")
        if (periods < 0).any():
            found.append(f"out_of_order: {int((periods < 0).sum())} messages before the last one")
        if rate_hz is not None:
            gaps = periods > _GAP_PERIODS * 1e9 / rate_hz
            if gaps.sum() > _GAPS_NAMED * len(periods):
                found.append(f"gaps: {int(gaps.sum())}, the longest of {1e-9 * periods.max():.2f} s")
        return found

    def _periods_ns(self) -> np.ndarray:
        return np.diff(np.array(self.arrived_ns, dtype=np.int64))


def counted(codes: dict[str, int]) -> list[str]:
    """Counts by code as findings."""
    return [f"{code}: {count}" for code, count in sorted(codes.items()) if count]
