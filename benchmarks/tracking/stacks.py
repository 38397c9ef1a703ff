"""The stacks of the tracking benchmark, and how each follows a curve. A new stack is one entry."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from benchmarks.tracking.reference_paths import ReferencePath
from benchmarks.tracking.scan_sensing import ScannedCurve
from benchmarks.tracking.sensing import Sensing, noisy, perfect
from benchmarks.tracking.timed_drive import SpeedRule, follow_timed, timed_rows
from benchmarks.tracking.waypoint_drive import Drive, follow, record
from simulator.sensors.gnss import GnssNoise
from simulator.vehicle.plant import PlantParams
from vehicle_agent.config import Profile
from vehicle_agent.control.trajectory.trajectory_control import TrajectoryControl
from vehicle_agent.control.waypoint.waypoint_control import WaypointControl
from vehicle_agent.stacks import nus, snow_lion_control
from vehicle_agent.stacks.rooms import waypoint_control

NO_NOISE = GnssNoise(0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Conditions:
    """params None: the profile's kinematic vehicle. noise None: perfect localization.

    scanned  the stack's own localization by scans; without it GNSS and inertial sensor
    """

    name: str
    params: PlantParams | None
    noise: GnssNoise | None
    scanned: ScannedCurve | None = None


@dataclass(frozen=True, slots=True)
class FollowTask:
    """One drive of the benchmark."""

    path: ReferencePath
    profile: Profile
    speed_mps: float
    seed: int
    conditions: Conditions


@dataclass(frozen=True, slots=True)
class TrackingResult:
    """driven_s over reference_s is the time ratio of the drive to its plan.

    The reference time is that of `timed_drive.SpeedRule` at the commanded speed, from rest. If the stack
    stops at the curve's end, the reference ends at rest there and driven_s when the vehicle stands. Otherwise
    both end when the vehicle passes the end.
    """

    drive: Drive
    driven_s: float
    reference_s: float


def follow_rows(stack: str, task: FollowTask, control: TrajectoryControl) -> TrackingResult:
    """Follow timed rows of the curve itself, from rest to rest."""
    rows = timed_rows(task.path, SpeedRule(task.speed_mps))
    drive = follow_timed(rows, task.profile, control, _params(task), _sensing(stack, task)).drive
    moving = drive.trace[:, 4] > 0.0
    return TrackingResult(drive, float(drive.trace[moving, 0].max(initial=0.0)), float(rows[-1, 0]))


def follow_waypoints(stack: str, task: FollowTask, control: WaypointControl) -> TrackingResult:
    """Follow waypoints recorded on the curve with the same noise, past its end without stopping."""
    noise = task.conditions.noise or NO_NOISE
    with tempfile.TemporaryDirectory() as folder:
        file = record(task.path, task.profile, task.speed_mps, Path(folder), task.seed, noise)
        drive = follow(
            task.path, file, task.profile, control, task.speed_mps, _sensing(stack, task),
            task.conditions.params,
        )  # fmt: skip
    rows = timed_rows(task.path, SpeedRule(task.speed_mps))
    cruise_mps = float(rows[:, 5].max())
    rise_s = float(rows[rows[:, 5] >= cruise_mps - 1e-6, 0].min())
    rise_m = float(rows[rows[:, 0] <= rise_s + 1e-9, 7].max())
    return TrackingResult(
        drive, float(drive.trace[-1, 0]), rise_s + (task.path.length_m - rise_m) / cruise_mps
    )


def _sensing(stack: str, task: FollowTask) -> Sensing:
    conditions = task.conditions
    if conditions.noise is None:
        return perfect
    if conditions.scanned is not None:
        return conditions.scanned.sensing(stack, task.profile, conditions.noise, task.seed)
    return noisy(task.seed, conditions.noise, task.profile)


def _params(task: FollowTask) -> PlantParams:
    return task.conditions.params or PlantParams(wheelbase_m=task.profile.body.wheelbase_m)


def _as_in_the_paper(control: WaypointControl) -> WaypointControl:
    """One gain at every speed, from the present pose without prediction; no trim."""
    follower = msgspec.structs.replace(control.follower, heading_gain_1ps=2.0, gain_speed_mps=0.0)
    return msgspec.structs.replace(control, follower=follower, steer_delay_s=0.0, trim=None, slip=None)


def _slower(task: FollowTask) -> FollowTask:
    """At the speed that its look-ahead allows; the reference time is that of this speed."""
    return replace(task, speed_mps=min(task.speed_mps, nus.SPEED_MPS_MAX))


# stack -> follower -> how it drives; the stack's figures are those of its follower "ours".
STACKS: dict[str, dict[str, Callable[[FollowTask], TrackingResult]]] = {
    "gem": {
        "ours": lambda task: follow_waypoints("gem", task, waypoint_control(task.profile)),
        "paper": lambda task: follow_waypoints("gem", task, _as_in_the_paper(waypoint_control(task.profile))),
    },
    "nus": {"ours": lambda task: follow_waypoints("nus", _slower(task), nus.pursuit_control(task.profile))},
    "snow_lion": {
        "ours": lambda task: follow_rows("snow_lion", task, snow_lion_control.control(task.profile))
    },
}
# Stacks published with a kinematic vehicle: they are also driven, and evaluated, on one.
KINEMATIC_STACKS = frozenset({"gem"})
