"""Records a path's waypoints by driving it exactly, and follows them on the simulated vehicle over CAN."""

import math
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.tracking.reference_paths import ReferencePath
from benchmarks.tracking.sensing import ORIGIN, Sensing
from contract.geometry import Array, Pose2, curvatures, pose_at, project
from simulator.fleet import STEP_NS, SimFleet
from simulator.sensors.gnss import GnssNoise, GnssReceiver
from simulator.sensors.imu import Imu, ImuNoise
from simulator.vehicle.plant import PlantParams, PlantView
from vehicle_agent.can.pacmod.codec import pacmod
from vehicle_agent.config import Profile
from vehicle_agent.control.waypoint.waypoint_control import WaypointControl
from vehicle_agent.localization.gnss_ins import GnssInsLocalization
from vehicle_agent.planning.waypoint.waypoint_planning import cruise
from vehicle_agent.planning.waypoint.waypoints import WaypointRules, Waypoints
from vehicle_agent.signals import Actuation, VehicleMotion
from vehicle_agent.signals import Path as PlannedPath
from vehicle_agent.waypoints.files import read_waypoints, write_recording
from vehicle_agent.waypoints.recorder import WaypointRecorder

_STEP_S = STEP_NS * 1e-9
_NAME = "gem"


@dataclass(frozen=True, slots=True)
class Drive:
    """One drive along a path: trace (n, 7) t, x, y, yaw, v, a, steer; cpu_s: of planning, control and CAN."""

    trace: Array
    finished: bool
    ticks: int
    cpu_s: float


def record(
    path: ReferencePath, profile: Profile, speed_mps: float, folder: Path, seed: int, noise: GnssNoise
) -> Path:
    """Drive the path exactly, with the sensors' noise, and write its waypoint file."""
    rng = np.random.default_rng([seed, 1])
    receiver, imu = GnssReceiver(ORIGIN, noise, rng), Imu(ImuNoise(), rng)
    localization = GnssInsLocalization(ORIGIN)
    state, recorder = localization.initial(), WaypointRecorder()
    kappa = curvatures(path.points)
    s_m, now_ns, length_m = 0.0, STEP_NS, path.length_m
    lateral_mps2 = profile.limits.lateral_accel_mps2_max
    while s_m <= length_m:
        k = float(np.interp(s_m, path.s, kappa))
        v = min(speed_mps, math.sqrt(lateral_mps2 / max(abs(k), 1e-6)))
        truth = PlantView(Pose2(*pose_at(path.points, path.s, s_m)), v, 0.0, 0.0, 0.0, 0.0, v * k, s_m, 1.0)
        motion = VehicleMotion(now_ns, v, 0.0, 0.0, 0.0, False, False, True, 1.0)
        fix = receiver.fix(now_ns, truth)
        assert fix is not None
        ego, state = localization.step(state, motion, (fix, imu.sample(now_ns, truth)), now_ns)
        recorder.observe(ego)
        s_m += v * _STEP_S
        now_ns += STEP_NS
    route = path.name.replace(" ", "-")
    return write_recording(folder, route, recorder.waypoints, ORIGIN, [speed_mps])[0]


def follow(
    path: ReferencePath,
    file: Path,
    profile: Profile,
    control: WaypointControl,
    speed_mps: float,
    sense: Sensing,
    params: PlantParams | None = None,
) -> Drive:
    """Follow a waypoint file from rest at the path's start to its end: localization, control, CAN.

    params: the vehicle's dynamics, instead of the profile's kinematic ones
    """
    limits = profile.limits
    rules = WaypointRules(speed_mps, limits.lateral_accel_mps2_max)
    waypoints = _with_overrun(read_waypoints(file, ORIGIN, rules), rules.overrun_m)
    start = Pose2(*pose_at(path.points, path.s, 0.0))
    fleet = SimFleet({_NAME: profile}, {_NAME: start}, None if params is None else {_NAME: params})
    can = pacmod(profile)
    can_state, ctl_state = can.initial(), control.initial()
    now_ns, segment, cpu_s = STEP_NS, 0, 0.0
    rows: list[tuple[float, ...]] = []
    goal_m = float(waypoints.s_m[-1]) - rules.overrun_m
    ticks_max = round(3.0 * path.length_m / min(speed_mps, 1.0) / _STEP_S)
    s_m = 0.0
    while s_m < goal_m - 0.05 and len(rows) < ticks_max:
        truth = fleet.truth(_NAME)
        motion, can_state = can.decode(can_state, fleet.frames_to_vehicle(_NAME), now_ns)
        ego = sense(now_ns, truth, motion)
        began_s = time.process_time()
        pose = ego.pose_map
        s_m, _, segment = project(
            waypoints.points_map, waypoints.s_m, pose.x_m, pose.y_m, segment - 3, segment + 8
        )
        speed = cruise(waypoints, s_m, ego.speed_mps, 0.25)
        ahead = waypoints.ahead(s_m, 30.0)
        planned = PlannedPath(
            now_ns, waypoints.points_map[ahead], waypoints.speeds_mps[ahead], speed.speed_mps, speed.name,
            None, goal_m - s_m, False, speed.accel_mps2,
        )  # fmt: skip
        command, ctl_state = control.step(ctl_state, ego, planned, motion)
        act = Actuation(True, "drive", command.steer_rad, command.throttle_ratio, command.brake_ratio)
        out, can_state = can.encode(can_state, act, now_ns)
        cpu_s += time.process_time() - began_s
        fleet.frames_from_vehicle(_NAME, out)
        fleet.step(now_ns)
        at = truth.pose_map
        rows.append(
            (now_ns * 1e-9, at.x_m, at.y_m, at.yaw_rad, truth.speed_mps, truth.accel_mps2, truth.steer_rad)
        )
        now_ns += STEP_NS
    return Drive(np.array(rows), s_m >= goal_m - 0.05, len(rows), cpu_s)


def _with_overrun(waypoints: Waypoints, overrun_m: float) -> Waypoints:
    """The waypoints extended straight on, so that there is a look-ahead point until the end."""
    a, b = waypoints.points_map[-2], waypoints.points_map[-1]
    step = (b - a) / np.hypot(*(b - a))
    distances = np.arange(1.0, overrun_m + 0.5)
    return Waypoints(
        np.vstack((waypoints.points_map, b + distances[:, None] * step)),
        np.concatenate((waypoints.s_m, waypoints.s_m[-1] + distances)),
        np.concatenate((waypoints.speeds_mps, np.full(len(distances), waypoints.speeds_mps[-1]))),
    )
