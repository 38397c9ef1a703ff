"""How much driving a battery still allows.

The estimates are conservative: the driving around a stand pays for it, and only long planned standing counts
as charging.
"""

from collections.abc import Iterable
from datetime import datetime, timedelta

from server.domain.rules import FleetRules


def is_measured(ratio: float) -> bool:
    """A vehicle that does not measure its battery reports 0; one with an empty battery reports nothing."""
    return ratio > 0.0


def drive_left_s(
    ratio: float, legs: Iterable[tuple[float, float]], home_s: float, rules: FleetRules, *, charging: bool
) -> float:
    """Planned seconds of driving in all: a route's own, and what may be added wherever in it.

    legs      of the route: seconds driven to a call, then seconds that the vehicle has to stand before it
    home_s    from the last call to a charger, at most
    charging  it went to charge: nothing is added below the ratio at which it accepts rides again

    The level falls with driving and rises with charging where the vehicle stands for long. What can be added
    is what the lowest level on the way leaves above the reserve.
    """
    level, driven_s = ratio, 0.0
    lowest = ratio
    for drive_s, idle_s in legs:
        at_charger_s = idle_s - rules.battery_rest_s_min
        if at_charger_s > 0.0:
            full = max(level, rules.battery_full_ratio)
            level = min(full, level + at_charger_s * rules.battery_per_charge_s)
        level -= drive_s * rules.battery_per_drive_s
        driven_s += drive_s
        lowest = min(lowest, level)
    if charging and ratio < rules.battery_accept_ratio:
        return driven_s
    spare_s = (lowest - rules.battery_reserve_ratio) / rules.battery_per_drive_s - home_s
    return driven_s + max(0.0, spare_s)


def charge_s(ratio: float, to_ratio: float, rules: FleetRules) -> float:
    """Seconds at a charger from one level to another."""
    return max(0.0, to_ratio - ratio) / rules.battery_per_charge_s


def charged_at(ratio: float, measured_at: datetime, rules: FleetRules) -> datetime:
    """When a vehicle that charges since `measured_at` is charged to the full."""
    return measured_at + timedelta(seconds=charge_s(ratio, rules.battery_full_ratio, rules))
