"""Reports of the module that contradict each other or the commands: speed and wheels, gear and command.

Each value alone is plausible. A speed that none of the wheels has, or a gear that nobody asked for, is how a
broken sensor or lever looks.
"""

import statistics

import msgspec

from vehicle_agent.can.faults import ActiveFault
from vehicle_agent.can.pacmod.reports import Reports
from vehicle_agent.signals import Gear, ReportedGear

# Wheels of a bend at the least radius turn 25 % faster or slower than the rear axle goes; a wheel that locks
# for a moment is no broken sensor.
_SHARE, _OFFSET_MPS = 0.35, 0.5
# So many wheel reports in a row (0.5 s at 30 Hz) must disagree.
DISAGREEING_REPORTS = 15
# A gearbox may take this long to shift.
SHIFTING_NS = 2_000_000_000


class Consistency(msgspec.Struct, frozen=True):
    """wheel_ns    stamp of the wheel report judged last
    speed_differs, wheel_differs  reports in a row in which the vehicle's speed, or one wheel, disagrees
    gear_since_ns  since when the gear is not the commanded one, 0 while it is
    """

    wheel_ns: int = 0
    speed_differs: int = 0
    wheel_differs: int = 0
    gear_since_ns: int = 0

    def faults(self, now_ns: int) -> list[ActiveFault]:
        found: list[ActiveFault] = []
        if self.speed_differs >= DISAGREEING_REPORTS:
            found.append(("bywire_speed_mismatch", "stop"))
        elif self.wheel_differs >= DISAGREEING_REPORTS:
            found.append(("bywire_wheel_mismatch", "warning"))
        if self.gear_since_ns and now_ns - self.gear_since_ns > SHIFTING_NS:
            found.append(("bywire_gear_mismatch", "stop"))
        return found


def check_consistency(
    before: Consistency,
    reports: Reports,
    gear: ReportedGear | None,
    commanded: Gear | None,
    wheel_radius_m: float,
    now_ns: int,
) -> Consistency:
    """After this tick's reports. commanded: the gear requested while by-wire is on, None while it is off."""
    since_ns = 0
    if commanded is not None and gear is not None and gear != commanded:
        since_ns = before.gear_since_ns or now_ns
    if reports.wheel_ns == before.wheel_ns or not reports.speed_ns:
        return msgspec.structs.replace(before, gear_since_ns=since_ns)
    wheels_mps = [
        radps * wheel_radius_m
        for radps in (
            reports.front_left_radps,
            reports.front_right_radps,
            reports.rear_left_radps,
            reports.rear_right_radps,
        )
    ]
    median_mps = statistics.median(wheels_mps)
    speed_differs = _differs(median_mps, reports.speed_mps)
    wheel_differs = any(_differs(wheel_mps, median_mps) for wheel_mps in wheels_mps)
    return Consistency(
        reports.wheel_ns,
        before.speed_differs + 1 if speed_differs else 0,
        before.wheel_differs + 1 if wheel_differs else 0,
        since_ns,
    )


def _differs(one_mps: float, other_mps: float) -> bool:
    return abs(one_mps - other_mps) > _OFFSET_MPS + _SHARE * max(abs(one_mps), abs(other_mps))
