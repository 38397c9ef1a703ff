"""Which stacks the tracking benchmark drives, and how each follows a curve. A new stack is one entry."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from benchmarks.tracking.reference_paths import ReferencePath
from benchmarks.tracking.timed_drive import (
    SpeedRule,
    follow_timed,
    noisy,
    perfect,
    timed_rows,
)
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
    """params None: the profile's kinematic vehicle. noise None: perfect localization."""

    name: str
    params: PlantParams | None
    noise: GnssNoise | None


@dataclass(frozen=True, slots=True)
class FollowTask:
    """One drive to be made."""

    path: ReferencePath
    profile: Profile
    speed_mps: float
    seed: int
    conditions: Conditions


@dataclass(frozen=True, slots=True)
class TrackingResult:
    """driven_s over reference_s is what the drive took beyond its plan.

    The reference time is that of the speed rule of `timed_drive.SpeedRule` at the commanded speed, from
    rest. For a stack that stops at the curve's end it ends at rest there, and driven_s when the vehicle
    stands; for one that rolls on it ends in passing the end.
    """

    drive: Drive
    driven_s: float
    reference_s: float


def timed(task: FollowTask, control: TrajectoryControl) -> TrackingResult:
    """By timed rows off the curve itself, from rest to rest."""
    rows = timed_rows(task.path, SpeedRule(task.speed_mps))
    noise = task.conditions.noise
    sense = perfect if noise is None else noisy(task.seed, noise)
    drive = follow_timed(rows, task.profile, control, _params(task), sense).drive
    moving = drive.trace[:, 4] > 0.0
    return TrackingResult(drive, float(drive.trace[moving, 0].max(initial=0.0)), float(rows[-1, 0]))


def by_waypoints(task: FollowTask, hands: WaypointControl) -> TrackingResult:
    """By waypoints recorded on the curve with the same noise; through its end without stopping."""
    noise = task.conditions.noise or NO_NOISE
    with tempfile.TemporaryDirectory() as folder:
        file = record(task.path, task.profile, task.speed_mps, Path(folder), task.seed, noise)
        drive = follow(
            task.path, file, task.profile, hands, task.speed_mps, task.seed, noise, task.conditions.params
        )
    rows = timed_rows(task.path, SpeedRule(task.speed_mps))
    cruise_mps = float(rows[:, 5].max())
    rise_s = float(rows[rows[:, 5] >= cruise_mps - 1e-6, 0].min())
    rise_m = float(rows[rows[:, 0] <= rise_s + 1e-9, 7].max())
    return TrackingResult(
        drive, float(drive.trace[-1, 0]), rise_s + (task.path.length_m - rise_m) / cruise_mps
    )


def _params(task: FollowTask) -> PlantParams:
    return task.conditions.params or PlantParams(wheelbase_m=task.profile.body.wheelbase_m)


def _as_in_the_paper(hands: WaypointControl) -> WaypointControl:
    """One gain at every speed, aimed from where the vehicle is now and not where it will be; no trim."""
    follower = msgspec.structs.replace(hands.follower, heading_gain_1ps=2.0, gain_speed_mps=0.0)
    return msgspec.structs.replace(hands, follower=follower, steer_delay_s=0.0, trim=None)


def _slower(task: FollowTask) -> FollowTask:
    """As fast as its look-ahead allows; the reference time is that of this speed."""
    return replace(task, speed_mps=min(task.speed_mps, nus.SPEED_MPS_MAX))


# stack -> follower -> how it drives; the stack's figures are those of its follower "ours".
STACKS: dict[str, dict[str, Callable[[FollowTask], TrackingResult]]] = {
    "gem": {
        "ours": lambda task: by_waypoints(task, waypoint_control(task.profile)),
        "paper": lambda task: by_waypoints(task, _as_in_the_paper(waypoint_control(task.profile))),
    },
    "nus": {"ours": lambda task: by_waypoints(_slower(task), nus.pursuit_control(task.profile))},
    "snow_lion": {"ours": lambda task: timed(task, snow_lion_control.control(task.profile))},
}
# Stacks that were published with a vehicle that rolls where its wheels point: also driven, and judged, on
# that.
KINEMATIC_STACKS = frozenset({"gem"})
