"""Converts a curve to a timed trajectory, and drives a stack along it over CAN."""

import math
import time
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from benchmarks.tracking.reference_paths import ReferencePath
from benchmarks.tracking.sensing import Sensing
from benchmarks.tracking.waypoint_drive import Drive
from contract.geometry import Array, Pose2, curvatures
from simulator.fleet import STEP_NS, SimFleet
from simulator.vehicle.plant import PlantParams
from vehicle_agent.can.pacmod.codec import pacmod
from vehicle_agent.config import Profile
from vehicle_agent.signals import Actuation, ControlCommand, Ego, Path, Trajectory, VehicleMotion

_STEP_S = STEP_NS * 1e-9
_NAME = "shuttle"
ROW_S = 0.1
# The length and rate of a planner's trajectories, and the time before the vehicle must start.
AHEAD_S = 8.0
PLAN_EVERY = 5
READY_S = 2.0


class TimedControl(Protocol):
    def initial(self) -> Any: ...
    def step(self, state: Any, ego: Ego, path: Path, motion: VehicleMotion) -> tuple[ControlCommand, Any]: ...


@dataclass(frozen=True, slots=True)
class SpeedRule:
    """The cruise speed, and the bounds of acceleration and jerk with which it is reached and left."""

    speed_mps: float = 3.0
    accel_mps2: float = 0.5
    jerk_mps3: float = 0.5
    lateral_mps2_max: float = 0.5


def timed_rows(path: ReferencePath, rule: SpeedRule) -> Array:
    """(k, 8) rows of `signals.Trajectory`, ROW_S apart, from rest at the curve's start to rest at its end.

    The speed is the rule's, everywhere within the lateral acceleration's bound; it rises and falls by an
    acceleration that itself rises and falls by the jerk. The last row's time is the reference time.
    """
    kappa = _smooth(curvatures(path.points[::10]), 5)
    s_kappa = path.s[::10]
    bound = np.sqrt(rule.lateral_mps2_max / np.maximum(np.abs(kappa), 1e-6))
    cruise_mps = min(rule.speed_mps, float(bound.min()))
    ramp_s, ramp_v = _ramp(cruise_mps, rule)
    rise_m = float(np.sum(ramp_v) * 1e-3)
    if 2.0 * rise_m > path.length_m:
        raise ValueError(f"{path.name} is too short to reach {cruise_mps:g} m/s and stop again")
    cruise_s = (path.length_m - 2.0 * rise_m) / cruise_mps
    total_s = 2.0 * ramp_s + cruise_s
    t = np.append(np.arange(0.0, total_s, ROW_S), total_s)
    fine = np.arange(len(ramp_v)) * 1e-3
    gone = np.concatenate(([0.0], np.cumsum(ramp_v) * 1e-3))[:-1]
    rising, falling = np.minimum(t, ramp_s), np.minimum(total_s - t, ramp_s)
    v = np.minimum(np.interp(rising, fine, ramp_v), np.interp(falling, fine, ramp_v))
    s = np.interp(rising, fine, gone) + cruise_mps * np.clip(t - ramp_s, 0.0, cruise_s)
    s += rise_m - np.interp(falling, fine, gone)
    s = np.clip(s * path.length_m / s[-1], 0.0, path.length_m)
    rows = np.zeros((len(t), 8))
    rows[:, 0], rows[:, 7], rows[:, 5] = t, s, v
    rows[:, 1], rows[:, 2] = np.interp(s, path.s, path.points[:, 0]), np.interp(s, path.s, path.points[:, 1])
    heading = np.unwrap(np.arctan2(*np.diff(path.points[::10], axis=0).T[::-1]))
    middles = 0.5 * (s_kappa[1:] + s_kappa[:-1])
    rows[:, 3], rows[:, 4] = np.interp(s, middles, heading), np.interp(s, s_kappa, kappa)
    rows[:, 6] = np.gradient(v, t)
    return rows


def _ramp(cruise_mps: float, rule: SpeedRule) -> tuple[float, Array]:
    """(seconds, speeds (n,) a millisecond apart) from rest to cruise."""
    accel = min(rule.accel_mps2, math.sqrt(cruise_mps * rule.jerk_mps3))
    bend_s = accel / rule.jerk_mps3
    total_s = cruise_mps / accel + bend_s
    t = np.arange(0.0, total_s + 1e-3, 1e-3)
    a = np.minimum(np.minimum(t, total_s - t) * rule.jerk_mps3, accel)
    v = np.concatenate(([0.0], np.cumsum(0.5 * (a[1:] + a[:-1])) * 1e-3))
    ramp: Array = np.clip(v * cruise_mps / v[-1], 0.0, cruise_mps)
    return total_s, ramp


def _smooth(values: Array, reach: int) -> Array:
    padded = np.pad(values, reach, mode="edge")
    smooth: Array = np.convolve(padded, np.full(2 * reach + 1, 1.0 / (2 * reach + 1)), "valid")
    return smooth


@dataclass(frozen=True, slots=True)
class TimedRun:
    """drive; for each tick control's command and the seconds that its step took; state: control's, at the
    end."""

    drive: Drive
    commands: list[ControlCommand]
    step_cpu_s: Array
    step_wall_s: Array
    state: Any


def follow_timed(
    rows: Array,
    profile: Profile,
    control: TimedControl,
    params: PlantParams,
    sense: Sensing,
    settle_s: float = 3.0,
) -> TimedRun:
    """Drive rows (k, 8) from rest at their beginning over CAN until settle_s after their end.

    The trajectory is passed in windows of AHEAD_S as a planner's would be, stamped so that row 0's time is
    READY_S after by-wire is requested. The trace's time 0 is row 0's.
    """
    start = Pose2(float(rows[0, 1]), float(rows[0, 2]), float(rows[0, 3]))
    fleet = SimFleet({_NAME: profile}, {_NAME: start}, {_NAME: params})
    can = pacmod(profile)
    can_state, ctl_state = can.initial(), control.initial()
    stamp_ns = STEP_NS + round(READY_S * 1e9)
    ticks = round((READY_S + float(rows[-1, 0]) + settle_s) / _STEP_S)
    trace, commands, times_s = np.zeros((ticks, 7)), [], np.zeros((ticks, 2))
    trajectory = window(rows, stamp_ns, 0.0)
    for tick in range(ticks):
        now_ns = (tick + 1) * STEP_NS
        truth = fleet.truth(_NAME)
        if tick % PLAN_EVERY == 0:
            trajectory = window(rows, stamp_ns, (now_ns - stamp_ns) * 1e-9)
        planned = Path(
            now_ns, trajectory.rows[:, 1:3], trajectory.rows[:, 5], float(trajectory.rows[0, 5]), "plan",
            None, 0.0, False, 0.0, trajectory,
        )  # fmt: skip
        motion, can_state = can.decode(can_state, fleet.frames_to_vehicle(_NAME), now_ns)
        ego = sense(now_ns, truth, motion)
        began_s = time.process_time(), time.perf_counter()
        command, ctl_state = control.step(ctl_state, ego, planned, motion)
        times_s[tick] = time.process_time() - began_s[0], time.perf_counter() - began_s[1]
        act = Actuation(True, "drive", command.steer_rad, command.throttle_ratio, command.brake_ratio)
        out, can_state = can.encode(can_state, act, now_ns)
        fleet.frames_from_vehicle(_NAME, out)
        fleet.step(now_ns)
        at = truth.pose_map
        trace[tick] = (
            (now_ns - stamp_ns) * 1e-9, at.x_m, at.y_m, at.yaw_rad, truth.speed_mps, truth.accel_mps2,
            truth.steer_rad,
        )  # fmt: skip
        commands.append(command)
    left_m = math.hypot(trace[-1, 1] - rows[-1, 1], trace[-1, 2] - rows[-1, 2])
    driven_m = fleet.truth(_NAME).odometer_m
    finished = left_m < 0.5 and trace[-1, 4] == 0.0 and driven_m > float(rows[-1, 7] - rows[0, 7]) - 1.0
    drive = Drive(trace, finished, ticks, float(times_s[:, 0].sum()))
    return TimedRun(drive, commands, times_s[:, 0], times_s[:, 1], ctl_state)


def window(rows: Array, stamp_ns: int, t_s: float) -> Trajectory:
    """The rows from a second before t_s to AHEAD_S after it, with their own stamp."""
    first = min(max(np.searchsorted(rows[:, 0], t_s - 1.0) - 1, 0), len(rows) - 2)
    last = max(np.searchsorted(rows[:, 0], t_s + AHEAD_S) + 1, first + 2)
    cut = rows[first:last].copy()
    began_s = float(cut[0, 0])
    cut[:, 0] -= began_s
    return Trajectory(stamp_ns + round(began_s * 1e9), cut)
