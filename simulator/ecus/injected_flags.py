"""Flags that a scenario has the by-wire module report: faults, timeouts, a subsystem that lets go."""

from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.pacmod.watchdog import COMPONENTS

# (report message, signal) of the DBC: of one bit, a component's two, or one of the broken sensors below.
Flag = tuple[str, str]
COUNTER_STANDS: Flag = ("component_report", "counter")
_NEUTRAL = 2.0
# What a broken sensor or lever reports in the place of its value.
BROKEN: dict[Flag, float] = {
    ("speed_report", "speed"): 0.0,
    ("wheel_report", "front_left"): 0.0,
    ("shift_report", "output"): _NEUTRAL,
}


class UnknownFlagError(Exception):
    """The module has no such report or flag; the message names both."""


def checked_flag(report: str, signal: str) -> Flag:
    """The flag. Raises UnknownFlagError."""
    layout = layouts().get(report)
    is_absent = report in COMPONENTS[1:]
    if layout is None or is_absent or "_report" not in report:
        raise UnknownFlagError(f"the by-wire module sends no {report!r}")
    found = layout.signals.get(signal)
    flag = (report, signal)
    if found is None or not (found.mask in (1, 3) or flag in BROKEN or flag == COUNTER_STANDS):
        raise UnknownFlagError(f"{report} has no flag {signal!r}")
    return flag


def with_flags(values: dict[str, dict[str, float]], flags: frozenset[Flag]) -> dict[str, dict[str, float]]:
    """The reports' values with each flag raised; `enabled` and the flags of readiness are lowered instead."""
    for flag in flags - {COUNTER_STANDS}:
        report, signal = flag
        values[report][signal] = BROKEN.get(flag, 0.0 if signal in _GOOD else 1.0)
    return values


_GOOD = frozenset({"enabled", "ready", "yaw_new", "yaw_valid"})
