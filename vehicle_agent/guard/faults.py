"""Everything that is wrong right now, as faults with the time each began."""

import msgspec

from vehicle_agent.signals import Ages, Ego, Fault, VehicleMotion, World

Found = tuple[str, str]


class Ageing(msgspec.Struct, frozen=True):
    """When an input is too old to drive by, ns; percept_ns 0 where the vehicle has no lidar."""

    motion_ns: int = 150_000_000
    pose_ns: int = 300_000_000
    percept_ns: int = 400_000_000
    path_ns: int = 200_000_000
    late_tick_ns: int = 60_000_000
    lost_tick_ns: int = 500_000_000


def current(
    ages: Ages,
    limits: Ageing,
    tick_ns: int,
    motion: VehicleMotion,
    ego: Ego,
    world: World,
    wish_is_finite: bool,
    by_wire_late: bool,
) -> dict[str, Fault]:
    """Faults by code. tick_ns: time since the tick before, 0 in the first one."""
    found = {fault.code: fault for fault in (*motion.faults, *ego.faults)}
    now_ns = ego.stamp_ns

    def add(code: str, severity: str, since_ns: int = now_ns) -> None:
        found.setdefault(code, Fault(code, severity, since_ns))  # type: ignore[arg-type]

    for name, age_ns, stale_ns in (
        ("motion", ages.motion_ns, limits.motion_ns),
        ("pose", ages.pose_ns, limits.pose_ns),
        ("percept", ages.percept_ns, limits.percept_ns),
        ("path", ages.path_ns, limits.path_ns),
    ):
        if stale_ns == 0:
            continue
        if age_ns < 0:
            add(f"{name}_missing", "stop")
        elif age_ns > stale_ns:
            add(f"{name}_stale", "stop", now_ns - age_ns)
    if world.blind and limits.percept_ns:
        add("lidar_blind", "stop")
    if not wish_is_finite:
        add("command_not_finite", "stop")
    if by_wire_late:
        add("by_wire_not_given", "stop")
    if tick_ns > limits.lost_tick_ns:
        add("tick_lost", "stop")
    elif tick_ns > limits.late_tick_ns:
        add("tick_late", "warning")
    return found


def begun(found: dict[str, Fault], before: tuple[Fault, ...], now_ns: int) -> tuple[Fault, ...]:
    """The faults in order of their codes, each with the time it began, as far as that is known."""
    known = {fault.code: fault.since_ns for fault in before}
    return tuple(
        Fault(code, found[code].severity, known.get(code) or found[code].since_ns or now_ns)
        for code in sorted(found)
    )
