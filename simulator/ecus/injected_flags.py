"""Flags that a scenario has the by-wire module report: faults, timeouts, a subsystem that lets go."""

from vehicle_agent.can.dbc import layouts

# (report message, signal of one bit) of the DBC.
Flag = tuple[str, str]


class UnknownFlagError(Exception):
    """The module has no such report or flag; the message names both."""


def checked_flag(report: str, signal: str) -> Flag:
    """The flag. Raises UnknownFlagError."""
    layout = layouts().get(report)
    if layout is None or not report.endswith("_report"):
        raise UnknownFlagError(f"the by-wire module sends no {report!r}")
    found = layout.signals.get(signal)
    if found is None or found.mask != 1:
        raise UnknownFlagError(f"{report} has no flag {signal!r}")
    return report, signal


def with_flags(values: dict[str, dict[str, float]], flags: frozenset[Flag]) -> dict[str, dict[str, float]]:
    """The reports' values with each flag raised; `enabled` and the flags of readiness are lowered instead."""
    for report, signal in flags:
        values[report][signal] = 0.0 if signal in _GOOD else 1.0
    return values


_GOOD = frozenset({"enabled", "ready", "yaw_new", "yaw_valid"})
