"""The ages of the guard's inputs, and the status for the server."""

import math

import msgspec

from contract.wire.messages import LocalizationReport, Status
from vehicle_agent.signals import (
    Ages,
    ControlCommand,
    Detections,
    Ego,
    Fault,
    GuardStatus,
    HmiOutput,
    Path,
    Task,
    VehicleMotion,
    fault_report,
)


def ages(now_ns: int, motion: VehicleMotion, ego: Ego, detections: Detections, path: Path) -> Ages:
    """The ages of the guard's inputs; -1 for an input that has never come."""
    return Ages(
        motion_ns=_age(now_ns, motion.stamp_ns),
        pose_ns=_age(now_ns, ego.pose_stamp_ns),
        percept_ns=_age(now_ns, detections.stamp_ns),
        path_ns=_age(now_ns, path.stamp_ns),
    )


def with_faults(
    motion: VehicleMotion, command: ControlCommand, of_lidars: tuple[Fault, ...]
) -> VehicleMotion:
    """What the vehicle reports with what control and perception find wrong: the guard judges all alike."""
    if not command.faults and not of_lidars:
        return motion
    return msgspec.structs.replace(motion, faults=(*motion.faults, *command.faults, *of_lidars))


def _age(now_ns: int, stamp_ns: int) -> int:
    # An input that arrives between the tick's stamp and the draining of the inbox is newer than the tick.
    return max(0, now_ns - stamp_ns) if stamp_ns > 0 else -1


def status(
    now_ns: int,
    ego: Ego,
    motion: VehicleMotion,
    task: Task,
    path: Path,
    guard_status: GuardStatus,
    hmi_output: HmiOutput,
) -> Status:
    """The vehicle's status; the link sets the session's epoch."""
    return Status(
        epoch=0,
        stamp_ns=now_ns,
        pose_map=ego.pose_map,
        speed_mps=ego.speed_mps,
        accel_mps2=ego.accel_mps2,
        steer_rad=ego.steer_rad,
        mode=guard_status.mode,
        battery_ratio=motion.battery_ratio,
        doors_open=task.doors_open,
        lane_id=task.lane_id,
        s_m=task.lane_s_m,
        order_id=task.order_id,
        revision=task.revision,
        visit_id=task.visit_id,
        aboard=task.aboard,
        screen=hmi_output.screen,
        spoken=hmi_output.announce,
        obstacle_m=path.obstacle_m,
        waiting_for=task.waiting_for,
        faults=tuple(fault_report(fault) for fault in guard_status.faults),
        hold_reason=guard_status.reason,
        hold_detail=guard_status.detail,
        localization=_localization(ego),
    )


def _localization(ego: Ego) -> LocalizationReport:
    """A vehicle that compares no scans waits for its first fix, and then has GNSS alone."""
    is_known = math.isfinite(ego.position_std_m)
    phase = ego.phase or ("gnss_only" if is_known else "waiting")
    return LocalizationReport(phase, ego.position_std_m if is_known else None, ego.agreement)
