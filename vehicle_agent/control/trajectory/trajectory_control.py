"""The Snow Lion stack's control: a timed trajectory followed by model predictive control (eqs. 3-6).

In flow order: the estimate of the vehicle (`observer`), the reference (`timed_path`, `timed_waypoints`),
speed and pedals (`speed_control`), the wheels (`steer_control`).
"""

import math

import msgspec
import numpy as np

from contract.geometry import Array, wrap_angle
from vehicle_agent.control.actuators import MSPEED, MX, MY, MYAW
from vehicle_agent.control.learned_bounds import LearnedBounds, LearnedBoundsState
from vehicle_agent.control.mpc.bounded import prepare
from vehicle_agent.control.trajectory.observer import Observer, ObserverState
from vehicle_agent.control.trajectory.speed_control import SpeedControl, SpeedControlResult, SpeedControlState
from vehicle_agent.control.trajectory.steer_control import SteerControl, SteerControlResult, SteerControlState
from vehicle_agent.control.trajectory.timed_path import (
    at_length,
    at_time,
    fault_number,
    lengths,
    nearest,
    stop_rows,
)
from vehicle_agent.control.trajectory.timed_waypoints import timed_rows
from vehicle_agent.signals import ControlCommand, Ego, Path, VehicleMotion

NO_FAULT, NO_PATH, NO_POSE, OFF_PATH, MALFORMED = range(5)


class TrajectoryControlState(msgspec.Struct, frozen=True):
    """What control remembers.

    commands (m, 3)     steering, throttle and brake of the last ticks, oldest first
    solves, infeasible  counts since boot; bounded: solves that met a bound
    """

    estimate: ObserverState
    commands: Array
    speed: SpeedControlState
    steer: SteerControlState
    solves: int = 0
    bounded: int = 0
    infeasible: int = 0
    bounds: LearnedBoundsState = LearnedBoundsState()


class TrajectoryReference(msgspec.Struct, frozen=True):
    """rows (k, 8) with lengths s (k,), the vehicle's place along them and the time since their stamp.

    fault  why the rows are not the planner's, `NO_FAULT` if they are
    """

    rows: Array
    s: Array
    own_s_m: float
    t_s: float
    fault: int


class TrajectoryControl(msgspec.Struct, frozen=True):
    """off_path_m, off_path_rad  farther from the trajectory it is not followed
    no_pose_s_max             without a usable pose for this long the vehicle stops
    """

    observer: Observer = Observer()
    speed: SpeedControl = SpeedControl()
    steer: SteerControl = SteerControl()
    accel_mps2: float = 0.6
    decel_mps2_comfort: float = 0.8
    off_path_m: float = 2.0
    off_path_rad: float = 1.0
    no_pose_s_max: float = 0.5
    bounds: LearnedBounds = LearnedBounds()
    dt_s: float = 0.02

    def initial(self) -> TrajectoryControlState:
        # Tables and workspaces are computed here, so that no tick waits for them.
        self.steer.mpc.prepare()
        prepare(self.steer.mpc.steps)
        prepare(self.speed.mpc.steps)
        pending_commands_max = self.observer.drivetrain.pending_commands_max(self.dt_s)
        return TrajectoryControlState(
            self.observer.initial(),
            np.zeros((pending_commands_max, 3)),
            self.speed.initial(),
            self.steer.initial(),
        )

    def step(
        self, state: TrajectoryControlState, ego: Ego, path: Path, motion: VehicleMotion
    ) -> tuple[ControlCommand, TrajectoryControlState]:
        """The command that follows path.trajectory, or path.points_map without one.

        Without either it is a comfortable stop. Commands are finite and within the limits for any input.
        """
        if not motion.enabled:
            state = self._without_by_wire(state, motion)
        if self._is_held_externally(state, motion):
            state = msgspec.structs.replace(state, speed=self.speed.held())
        holding = state.speed.pedals.holding
        estimate = self.observer.step(state.estimate, ego, motion, state.commands, holding)
        bounds, begins_again = self.bounds.step(
            state.bounds,
            self.observer.is_steering_at_bound(estimate),
            self.observer.are_pedals_at_bound(estimate),
            ego,
            motion,
        )
        if begins_again:
            estimate = self.observer.begun_again(estimate)
        state = msgspec.structs.replace(state, bounds=bounds)
        reference = self._reference(ego, path, estimate)
        speed_reference = (
            reference if reference.fault == NO_FAULT else self._stop_reference(estimate, reference.fault)
        )
        emergency = path.emergency and motion.enabled
        speed = self.speed.step(
            state.speed, estimate, self.observer, state.commands, speed_reference.rows, speed_reference.s,
            speed_reference.own_s_m, speed_reference.t_s, emergency,
        )  # fmt: skip
        if reference.fault in (NO_FAULT, NO_POSE):
            steer = self.steer.step(
                state.steer, estimate, self.observer, state.commands, reference.rows, reference.s,
                reference.own_s_m,                speed.speeds_mps, speed.lead_s,
            )  # fmt: skip
        else:
            steer = SteerControlResult(self.steer.ease_straight(state.steer), 0.0, 0.0, False, True, 0)
        return self._command(state, estimate, reference, speed, steer)

    def _is_held_externally(self, state: TrajectoryControlState, motion: VehicleMotion) -> bool:
        """The guard's or the gate's brake holds the vehicle, for minutes perhaps.

        Pedals that wind up meanwhile would make the vehicle leap when the brake is released.
        """
        return motion.speed_mps == 0.0 and self.observer.is_braked_externally(motion, state.commands)

    def _without_by_wire(
        self, state: TrajectoryControlState, motion: VehicleMotion
    ) -> TrajectoryControlState:
        """The state without by-wire: it follows the reports."""
        limit = self.steer.mpc.steer_rad_max
        steer_rad = min(max(motion.steer_rad, -limit), limit) if math.isfinite(motion.steer_rad) else 0.0
        commands = np.zeros_like(state.commands)
        commands[:, 0] = steer_rad
        return msgspec.structs.replace(
            state,
            commands=commands,
            speed=self.speed.initial(),
            steer=SteerControlState(steer_rad, self.steer.initial().warm_start),
        )

    def _reference(self, ego: Ego, path: Path, estimate: ObserverState) -> TrajectoryReference:
        vehicle = estimate.vehicle
        fault = NO_FAULT
        rows, stamp_ns = np.zeros((0, 8)), ego.stamp_ns
        if path.trajectory is not None:
            rows, stamp_ns = (
                np.ascontiguousarray(path.trajectory.rows, dtype=np.float64),
                path.trajectory.stamp_ns,
            )
            fault = MALFORMED if rows.ndim != 2 or fault_number(rows) else NO_FAULT
        else:
            rows = self._waypoint_rows(path, estimate)
            fault = NO_PATH if len(rows) < 2 else NO_FAULT
            fault = MALFORMED if fault == NO_FAULT and fault_number(rows) else fault
        if fault == NO_FAULT:
            s, t_s = lengths(rows), (ego.stamp_ns - stamp_ns) * 1e-9
            near_m, _ = at_time(rows, s, t_s, self.decel_mps2_comfort)
            own_s_m, offset_m = nearest(rows, s, vehicle[MX], vehicle[MY], near_m, self.steer.search_m)
            if self._can_follow(rows, s, estimate, own_s_m, offset_m):
                if estimate.pose_estimate.fix_ns and estimate.pose_estimate.no_pose_s <= self.no_pose_s_max:
                    return TrajectoryReference(rows, s, own_s_m, t_s, NO_FAULT)
                # Dead reckoning is sufficient for a stop with the planned steering.
                return TrajectoryReference(rows, s, own_s_m, t_s, NO_POSE)
            fault = OFF_PATH
        return self._stop_reference(estimate, fault)

    def _stop_reference(self, estimate: ObserverState, fault: int) -> TrajectoryReference:
        """The reference of a comfortable straight stop from here."""
        x_m, y_m, yaw_rad, speed_mps = estimate.vehicle[[MX, MY, MYAW, MSPEED]].tolist()
        rows = stop_rows(x_m, y_m, yaw_rad, speed_mps, self.decel_mps2_comfort)
        return TrajectoryReference(rows, lengths(rows), 0.0, 0.0, fault)

    def _waypoint_rows(self, path: Path, estimate: ObserverState) -> Array:
        """(k, 8) rows from the path's waypoints; (0, 8) without usable ones."""
        points = np.ascontiguousarray(path.points_map, dtype=np.float64)
        speeds = np.ascontiguousarray(path.speeds_mps, dtype=np.float64)
        is_valid = (
            points.ndim == 2
            and len(points) == len(speeds)
            and bool(np.isfinite(points).all() and np.isfinite(speeds).all())
            and math.isfinite(path.speed_mps)
        )
        if not is_valid or len(points) < 2:
            return np.zeros((0, 8))
        x_m, y_m, yaw_rad = estimate.vehicle[[MX, MY, MYAW]].tolist()
        rows: Array = timed_rows(
            points, speeds, x_m, y_m, yaw_rad, max(0.0, path.speed_mps), estimate.speed_mps,
            self.accel_mps2, self.decel_mps2_comfort,
        )  # fmt: skip
        return rows

    def _can_follow(
        self, rows: Array, s: Array, estimate: ObserverState, own_s_m: float, offset_m: float
    ) -> bool:
        beyond_m = max(float(s[0]) - own_s_m, own_s_m - float(s[-1]), 0.0)
        yaw_rad, _ = at_length(rows, s, own_s_m)
        heading_error_rad = float(wrap_angle(estimate.vehicle[MYAW] - yaw_rad))
        is_near = abs(offset_m) < self.off_path_m and beyond_m < self.steer.search_m
        return is_near and abs(heading_error_rad) < self.off_path_rad

    def _command(
        self,
        state: TrajectoryControlState,
        estimate: ObserverState,
        reference: TrajectoryReference,
        speed: SpeedControlResult,
        steer: SteerControlResult,
    ) -> tuple[ControlCommand, TrajectoryControlState]:
        pedals = speed.state.pedals
        actuators = (steer.state.command_rad, pedals.throttle_ratio, pedals.brake_ratio)
        command = ControlCommand(
            steer_rad=actuators[0],
            throttle_ratio=actuators[1],
            brake_ratio=actuators[2],
            accel_mps2=speed.state.accel_mps2,
            diagnostics=(
                ("offset_m", steer.offset_m),
                ("heading_error_rad", steer.heading_rad),
                ("behind_m", speed.behind_m),
                ("speed_missing_mps", speed.speed_error_mps),
                ("steer_bias_rad", estimate.steer_bias_rad),
                ("tyre_compliance", estimate.compliance),
                ("rest_accel_mps2", estimate.disturbance_mps2),
                ("drive_gain", estimate.pedals.drive_gain),
                ("brake_gain", estimate.pedals.brake_gain),
                ("path_fault", float(reference.fault)),
                ("solver_iterations", float(speed.iterations + steer.iterations)),
            ),
            faults=state.bounds.faults,
        )
        new = TrajectoryControlState(
            estimate,
            np.vstack((state.commands[1:], actuators)),
            speed.state,
            steer.state,
            state.solves + 1,
            state.bounded + int(speed.bounded or steer.bounded),
            state.infeasible + int(not (speed.feasible and steer.feasible)),
            state.bounds,
        )
        return command, new
