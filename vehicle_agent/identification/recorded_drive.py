"""The signals of a recorded run, for identification."""

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from contract.runlog.reader import RunLogError, open_segment, ticks
from vehicle_agent.config import Profile
from vehicle_agent.identification.drive_signals import DT_S, DriveSignals
from vehicle_agent.signals import Actuation, Ego, VehicleMotion

# A reported brake this far above the commands of the last second is the gate's or the driver's.
_FOREIGN_BRAKE_RATIO = 0.1


class _Signals(msgspec.Struct):
    """The part of a tick's record that is read."""

    motion: VehicleMotion
    ego: Ego
    actuation: Actuation


def recorded_drive(segments: Sequence[Path]) -> tuple[DriveSignals, Profile]:
    """(the drive, the profile that the vehicle had).

    Raises RunLogError, also for segments of two vehicles.
    """
    decoder = msgspec.msgpack.Decoder(_Signals)
    profile: Profile | None = None
    rows: list[tuple[float, ...]] = []
    reports: list[tuple[float, float, float]] = []
    report_ns = 0
    for path in segments:
        attached = msgspec.msgpack.decode(open_segment(path).profile, type=Profile)
        if profile is not None and attached != profile:
            raise RunLogError("other_vehicle", f"{path} was recorded with another vehicle profile")
        profile = attached
        for record in ticks(path):
            signals = decoder.decode(record.rooms)
            motion = signals.motion
            rows.append(_row(record.stamp_ns, signals))
            if motion.stamp_ns > report_ns:
                report_ns = motion.stamp_ns
                reports.append((report_ns * 1e-9, motion.speed_mps, motion.steer_rad))
    if profile is None or not rows:
        raise RunLogError("empty", "these segments hold no ticks")
    return _drive(np.array(rows), np.array(reports).reshape(-1, 3)), profile


def _row(stamp_ns: int, signals: _Signals) -> tuple[float, ...]:
    motion, ego, act = signals.motion, signals.ego, signals.actuation
    driving = motion.enabled and act.enable and act.gear == "drive"
    return (
        stamp_ns * 1e-9,
        act.steer_rad,
        act.throttle_ratio,
        act.brake_ratio,
        float(driving),
        ego.yaw_rate_radps if ego.valid else np.nan,
        ego.pose_map.yaw_rad if ego.valid else np.nan,
        motion.brake_ratio,
    )


def _drive(rows: np.ndarray, reports: np.ndarray) -> DriveSignals:
    commanded = rows[:, 3]
    back = round(1.0 / DT_S)
    padded = np.concatenate((np.full(back, commanded[0]), commanded))
    recent = np.lib.stride_tricks.sliding_window_view(padded, back + 1).max(axis=1)
    foreign = rows[:, 7] > recent + _FOREIGN_BRAKE_RATIO
    return DriveSignals(
        tick_s=rows[:, 0],
        commands=rows[:, 1:4],
        driving=(rows[:, 4] > 0.5) & ~foreign,
        yaw_rate_radps=rows[:, 5],
        heading_rad=rows[:, 6],
        report_s=reports[:, 0],
        speed_mps=reports[:, 1],
        steer_rad=reports[:, 2],
    )
