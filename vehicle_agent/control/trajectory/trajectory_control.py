"""The Snow Lion stack's control: a timed trajectory followed by model predictive control (eqs. 3-6).

In flow order: what is believed of the vehicle (`observer`), what is asked of it (`timed_path`,
`made_path`), the speed with its pedals (`speed_control`), the wheels (`steer_control`).
"""

import math

import msgspec
import numpy as np

from contract.geometry import Array, wrap_angle
from vehicle_agent.control.actuators import MSPEED, MX, MY, MYAW
from vehicle_agent.control.mpc.bounded import prepare
from vehicle_agent.control.trajectory.observer import Observer, ObserverState
from vehicle_agent.control.trajectory.speed_control import SpeedControl, SpeedControlResult, SpeedControlState
from vehicle_agent.control.trajectory.steer_control import SteerControl, SteerControlResult, SteerControlState
from vehicle_agent.control.trajectory.timed_path import (
    at_length,
    at_time,
    braking,
    fault_number,
    lengths,
    nearest,
)
from vehicle_agent.control.trajectory.timed_waypoints import timed
from vehicle_agent.signals import ControlCommand, Ego, Path, VehicleMotion

NO_FAULT, NOTHING, BLIND, ASTRAY, MALFORMED = range(5)


class TrajectoryControlState(msgspec.Struct, frozen=True):
    """What control remembers; commands (m, 3) steering, throttle and brake of the last ticks, oldest first.

    solves, infeasible  counted since boot; bounded: those of them that met a bound
    """

    observed: ObserverState
    commands: Array
    speeding: SpeedControlState
    steering: SteerControlState
    solves: int = 0
    bounded: int = 0
    infeasible: int = 0


class TrajectoryReference(msgspec.Struct, frozen=True):
    """rows (k, 8), lengths s (k,), the vehicle's place along them and its time since their stamp; fault:
    why they are not the planner's."""

    rows: Array
    s: Array
    own_s_m: float
    t_s: float
    fault: int


class TrajectoryControl(msgspec.Struct, frozen=True):
    """astray_m, astray_rad  farther off the trajectory there is nothing to follow
    blind_s_max          without a pose that can be believed for this long the vehicle stops
    """

    observer: Observer = Observer()
    speed: SpeedControl = SpeedControl()
    steer: SteerControl = SteerControl()
    accel_mps2: float = 0.6
    decel_mps2_comfort: float = 0.8
    astray_m: float = 2.0
    astray_rad: float = 1.0
    blind_s_max: float = 0.5
    dt_s: float = 0.02

    def initial(self) -> TrajectoryControlState:
        # Tables and workspaces: no tick may wait for them.
        self.steer.mpc.prepare()
        prepare(self.steer.mpc.steps)
        prepare(self.speed.mpc.steps)
        memory = self.observer.drivetrain.memory(self.dt_s)
        return TrajectoryControlState(
            self.observer.initial(), np.zeros((memory, 3)), self.speed.initial(), self.steer.initial()
        )

    def step(
        self, state: TrajectoryControlState, ego: Ego, path: Path, motion: VehicleMotion
    ) -> tuple[ControlCommand, TrajectoryControlState]:
        """Follow path.trajectory, or what can be made of path.points_map; comfortably to a stop where
        neither can be. Commands are finite and within the limits whatever comes in."""
        if not motion.enabled:
            state = self._hands_off(state, motion)
        if self._kept(state, motion):
            state = msgspec.structs.replace(state, speeding=self.speed.initial())
        holding = state.speeding.foot.holding
        seen = self.observer.step(state.observed, ego, motion, state.commands, holding)
        asked = self._asked(ego, path, seen)
        times = asked if asked.fault == NO_FAULT else self._stop(seen, asked.fault)
        emergency = path.emergency and motion.enabled
        speed = self.speed.step(
            state.speeding, seen, self.observer, state.commands, times.rows, times.s, times.own_s_m,
            times.t_s, emergency,
        )  # fmt: skip
        if asked.fault in (NO_FAULT, BLIND):
            steer = self.steer.step(
                state.steering, seen, self.observer, state.commands, asked.rows, asked.s, asked.own_s_m,
                speed.speeds_mps, speed.lead_s,
            )  # fmt: skip
        else:
            steer = SteerControlResult(self.steer.eased(state.steering), 0.0, 0.0, False, True, 0)
        return self._wish(state, seen, asked, speed, steer)

    def _kept(self, state: TrajectoryControlState, motion: VehicleMotion) -> bool:
        """Somebody else's brake keeps the vehicle standing, for minutes perhaps. What were commanded
        against it meanwhile would make the vehicle leap once it is let go."""
        return motion.speed_mps == 0.0 and self.observer.is_braked_by_others(motion, state.commands)

    def _hands_off(self, state: TrajectoryControlState, motion: VehicleMotion) -> TrajectoryControlState:
        """By-wire is not ours: go on from what the vehicle does by itself."""
        limit = self.steer.mpc.steer_rad_max
        steer_rad = min(max(motion.steer_rad, -limit), limit) if math.isfinite(motion.steer_rad) else 0.0
        commands = np.zeros_like(state.commands)
        commands[:, 0] = steer_rad
        return msgspec.structs.replace(
            state,
            commands=commands,
            speeding=self.speed.initial(),
            steering=SteerControlState(steer_rad, self.steer.initial().guess),
        )

    def _asked(self, ego: Ego, path: Path, seen: ObserverState) -> TrajectoryReference:
        moving = seen.moving
        fault = NO_FAULT
        rows, stamp_ns = np.zeros((0, 8)), ego.stamp_ns
        if path.trajectory is not None:
            rows, stamp_ns = (
                np.ascontiguousarray(path.trajectory.rows, dtype=np.float64),
                path.trajectory.stamp_ns,
            )
            fault = MALFORMED if rows.ndim != 2 or fault_number(rows) else NO_FAULT
        else:
            rows = self._made(path, seen)
            fault = NOTHING if len(rows) < 2 else NO_FAULT
            fault = MALFORMED if fault == NO_FAULT and fault_number(rows) else fault
        if fault == NO_FAULT:
            s, t_s = lengths(rows), (ego.stamp_ns - stamp_ns) * 1e-9
            near_m, _ = at_time(rows, s, t_s, self.decel_mps2_comfort)
            own_s_m, offset_m = nearest(rows, s, moving[MX], moving[MY], near_m, self.steer.search_m)
            if self._followable(rows, s, seen, own_s_m, offset_m):
                if seen.belief.fix_ns and seen.belief.blind_s <= self.blind_s_max:
                    return TrajectoryReference(rows, s, own_s_m, t_s, NO_FAULT)
                # Dead reckoning is good for a stop: the wheels go on as planned.
                return TrajectoryReference(rows, s, own_s_m, t_s, BLIND)
            fault = ASTRAY
        return self._stop(seen, fault)

    def _stop(self, seen: ObserverState, fault: int) -> TrajectoryReference:
        """Straight on from here, comfortably to a stop."""
        x_m, y_m, yaw_rad, speed_mps = seen.moving[[MX, MY, MYAW, MSPEED]].tolist()
        rows = braking(x_m, y_m, yaw_rad, speed_mps, self.decel_mps2_comfort)
        return TrajectoryReference(rows, lengths(rows), 0.0, 0.0, fault)

    def _made(self, path: Path, seen: ObserverState) -> Array:
        """Rows out of waypoints; (0, 8) when there are none to be had."""
        points = np.ascontiguousarray(path.points_map, dtype=np.float64)
        speeds = np.ascontiguousarray(path.speeds_mps, dtype=np.float64)
        ordinary = (
            points.ndim == 2
            and len(points) == len(speeds)
            and bool(np.isfinite(points).all() and np.isfinite(speeds).all())
            and math.isfinite(path.speed_mps)
        )
        if not ordinary or len(points) < 2:
            return np.zeros((0, 8))
        x_m, y_m, yaw_rad = seen.moving[[MX, MY, MYAW]].tolist()
        made: Array = timed(
            points, speeds, x_m, y_m, yaw_rad, max(0.0, path.speed_mps), seen.speed_mps,
            self.accel_mps2, self.decel_mps2_comfort,
        )  # fmt: skip
        return made

    def _followable(
        self, rows: Array, s: Array, seen: ObserverState, own_s_m: float, offset_m: float
    ) -> bool:
        beyond_m = max(float(s[0]) - own_s_m, own_s_m - float(s[-1]), 0.0)
        yaw_rad, _ = at_length(rows, s, own_s_m)
        turned_rad = float(wrap_angle(seen.moving[MYAW] - yaw_rad))
        near = abs(offset_m) < self.astray_m and beyond_m < self.steer.search_m
        return near and abs(turned_rad) < self.astray_rad

    def _wish(
        self,
        state: TrajectoryControlState,
        seen: ObserverState,
        asked: TrajectoryReference,
        speed: SpeedControlResult,
        steer: SteerControlResult,
    ) -> tuple[ControlCommand, TrajectoryControlState]:
        foot = speed.state.foot
        given = (steer.state.command_rad, foot.throttle_ratio, foot.brake_ratio)
        wish = ControlCommand(
            steer_rad=given[0],
            throttle_ratio=given[1],
            brake_ratio=given[2],
            accel_mps2=speed.state.accel_mps2,
            diagnostics=(
                ("offset_m", steer.offset_m),
                ("heading_error_rad", steer.heading_rad),
                ("behind_m", speed.behind_m),
                ("speed_missing_mps", speed.missing_mps),
                ("steer_bias_rad", seen.steer_bias_rad),
                ("tyre_compliance", seen.compliance),
                ("rest_accel_mps2", seen.rest_mps2),
                ("path_fault", float(asked.fault)),
                ("solver_iterations", float(speed.iterations + steer.iterations)),
            ),
        )
        after = TrajectoryControlState(
            seen,
            np.vstack((state.commands[1:], given)),
            speed.state,
            steer.state,
            state.solves + 1,
            state.bounded + int(speed.bounded or steer.bounded),
            state.infeasible + int(not (speed.feasible and steer.feasible)),
        )
        return wish, after
