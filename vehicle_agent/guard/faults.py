"""The faults that are present now, each with the time it began."""

import math

import msgspec

from contract.wire.messages import DriveMode, FaultRaised
from contract.wire.reasons import FaultCode, FaultSeverity
from vehicle_agent.guard.road_users import are_finite
from vehicle_agent.signals import Ages, Ego, Fault, VehicleMotion, World, fault_report
from vehicle_agent.signals.rates import (
    CAN_FRAME_AGE_NS_MAX,
    LATE_TICK_FAULT_NS,
    LOST_TICK_FAULT_NS,
    PATH_AGE_NS_MAX,
    PERCEPT_AGE_NS_MAX,
    POSE_AGE_NS_MAX,
)

_INPUT_FAULTS = ("pose_", "percept_", "path_", "lidar_", "command_")


class AgeLimits(msgspec.Struct, frozen=True):
    """When an input is too old to drive by, ns; percept_ns 0 where no sensor looks at the road."""

    motion_ns: int = CAN_FRAME_AGE_NS_MAX
    pose_ns: int = POSE_AGE_NS_MAX
    percept_ns: int = PERCEPT_AGE_NS_MAX
    path_ns: int = PATH_AGE_NS_MAX
    late_tick_ns: int = LATE_TICK_FAULT_NS
    lost_tick_ns: int = LOST_TICK_FAULT_NS


def current_faults(
    ages: Ages,
    limits: AgeLimits,
    tick_ns: int,
    motion: VehicleMotion,
    ego: Ego,
    world: World,
    command_is_finite: bool,
    by_wire_late: bool,
) -> dict[FaultCode, Fault]:
    """The present faults by code. tick_ns: time since the last tick, 0 in the first one."""
    found: dict[FaultCode, Fault] = {fault.code: fault for fault in (*motion.faults, *ego.faults)}
    now_ns = ego.stamp_ns
    pose = (ego.pose_map.x_m, ego.pose_map.y_m, ego.pose_map.yaw_rad, ego.speed_mps)

    def add(code: FaultCode, severity: FaultSeverity, since_ns: int = now_ns) -> None:
        # A room may have reported the same code as a warning; a fault that stops the vehicle counts.
        known = found.get(code)
        if known is None or (severity == "stop" and known.severity != "stop"):
            found[code] = Fault(code, severity, since_ns, "" if known is None else known.detail)

    inputs: tuple[tuple[FaultCode, FaultCode, int, int], ...] = (
        ("motion_missing", "motion_stale", ages.motion_ns, limits.motion_ns),
        ("pose_missing", "pose_stale", ages.pose_ns, limits.pose_ns),
        ("percept_missing", "percept_stale", ages.percept_ns, limits.percept_ns),
        ("path_missing", "path_stale", ages.path_ns, limits.path_ns),
    )
    for missing, stale, age_ns, stale_ns in inputs:
        if stale_ns == 0:
            continue
        if age_ns < 0:
            add(missing, "stop")
        elif age_ns > stale_ns:
            add(stale, "stop", now_ns - age_ns)
    if not all(map(math.isfinite, pose)):
        add("pose_not_finite", "stop")
    if not are_finite(world.tracks):
        add("tracks_not_finite", "warning")
    if world.blind and limits.percept_ns:
        add("lidar_blind", "stop")
    if not command_is_finite:
        add("command_not_finite", "stop")
    if by_wire_late:
        add("by_wire_not_given", "stop")
    if tick_ns < 0:
        add("clock_went_back", "stop")
    elif tick_ns > limits.lost_tick_ns:
        add("tick_lost", "stop")
    elif tick_ns > limits.late_tick_ns:
        add("tick_late", "warning")
    return found


def with_start_times(
    found: dict[FaultCode, Fault], before: tuple[Fault, ...], now_ns: int
) -> tuple[Fault, ...]:
    """The faults in order of their codes; one that was there before keeps its start time."""
    known = {fault.code: fault.since_ns for fault in before}
    return tuple(
        Fault(
            code, found[code].severity, known.get(code) or found[code].since_ns or now_ns, found[code].detail
        )
        for code in sorted(found)
    )


def fault_events(
    reported: tuple[Fault, ...], faults: tuple[Fault, ...], mode: DriveMode, now_ns: int, report_after_ns: int
) -> tuple[tuple[Fault, ...], tuple[FaultRaised, ...]]:
    """(faults reported by now, events for what was raised or cleared).

    While the vehicle is held or driven manually, a fault is reported only after report_after_ns: inputs that
    are still missing at boot raise no event at once. A fault of other devices than before is another one.
    """
    known = {(fault.code, fault.detail) for fault in reported}
    raised = tuple(
        fault
        for fault in faults
        if (fault.code, fault.detail) not in known
        and fault.severity != "info"
        and (mode not in ("held", "manual") or now_ns - fault.since_ns > report_after_ns)
    )
    active = {(fault.code, fault.detail) for fault in faults}
    cleared = tuple(fault for fault in reported if (fault.code, fault.detail) not in active)
    kept = tuple(fault for fault in reported if (fault.code, fault.detail) in active)
    events = tuple(FaultRaised(fault_report(fault)) for fault in raised)
    return kept + raised, events + tuple(FaultRaised(fault_report(fault), True) for fault in cleared)


def is_by_wire_sound(latched: tuple[Fault, ...]) -> bool:
    """All latched faults are of the tick's inputs; by-wire still follows commands, so a milder stop is safe.

    The gate also still monitors the footprint. When frames, reports or the clock are faulty, the vehicle may
    not follow the next command, and the stop is firmer.
    """
    return all(fault.code.startswith(_INPUT_FAULTS) for fault in latched)


def reported_faults(faults: tuple[Fault, ...], latched: tuple[Fault, ...]) -> tuple[Fault, ...]:
    """Active faults, and cleared faults that still hold the vehicle."""
    active = {fault.code for fault in faults}
    return faults + tuple(fault for fault in latched if fault.code not in active)
