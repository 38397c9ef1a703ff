"""The GEM stack's planning: waypoints to follow, and the lowest of all speed commands (GEM, section II)."""

import math

import msgspec
import numpy as np

from contract.roads.routing import ReferenceLine
from vehicle_agent.planning.waypoint.approach import Approach
from vehicle_agent.planning.waypoint.following import (
    NOTHING,
    ResumeRule,
    WaypointState,
    next_tick,
    no_path,
    path_along,
    standing_commands,
    stop_reason,
    uncertainty_commands,
)
from vehicle_agent.planning.waypoint.gap import GapRule
from vehicle_agent.planning.waypoint.obstacle import ObstacleRule, sweep_arc, sweep_line
from vehicle_agent.planning.waypoint.recorded import RecordedWay, waypoints_on_line
from vehicle_agent.planning.waypoint.selector import SpeedCommand, lowest
from vehicle_agent.planning.waypoint.signs import SignMemory, SignRule
from vehicle_agent.planning.waypoint.waypoints import WaypointRules, Waypoints, waypoints_from_line
from vehicle_agent.signals import Ego, Path, PlanAnswer, PlanJob, Task, World

# Under way, the waypoints' own speeds stop a vehicle where its recording ends.
_STANDING_MPS = 0.1


class PathCheck(msgspec.Struct, frozen=True):
    """The last check along the path: at which scan and odometer, and how far the bumper could go.

    beside_m  distance to the nearest point just beside the path
    """

    seen_ns: int = -1
    odometer_m: float = 0.0
    free_m: float = math.inf
    beside_m: float = math.inf


class WaypointPlanningState(WaypointState, frozen=True):
    """What planning remembers. covered_m: how far along the line the waypoints can be driven."""

    check: PathCheck = PathCheck()
    covered_m: float = math.inf
    signs: SignMemory = SignMemory()


class WaypointPlanning(msgspec.Struct, frozen=True):
    """Parameters of every speed command.

    recorded        a recorded way to drive instead of the map's lines; an order that it does not cover is not
                    driven ("no_plan")
    signs           None: signs are not obeyed
    look_every      ticks between looks along the path when no new scan comes
    delay_s         how far ahead in time speeds are read from the waypoints
    """

    waypoints: WaypointRules
    obstacle: ObstacleRule
    gap: GapRule
    approach: Approach = Approach()
    patience: ResumeRule = ResumeRule()
    recorded: RecordedWay | None = None
    signs: SignRule | None = None
    look_every: int = 5
    delay_s: float = 0.25
    ahead_m: float = 30.0

    def initial(self) -> WaypointPlanningState:
        return WaypointPlanningState()

    def jobs(self, state: WaypointPlanningState) -> tuple[PlanJob, ...]:
        return ()

    def step(
        self,
        state: WaypointPlanningState,
        ego: Ego,
        world: World,
        task: Task,
        plans: tuple[PlanAnswer, ...] = (),
    ) -> tuple[Path, WaypointPlanningState]:
        """The waypoints ahead and the speed to follow now.

        Without a line the vehicle stands. It needs no planner.
        """
        state = next_tick(state, ego)
        if task.line is None:
            return no_path(ego), msgspec.structs.replace(state, line_id=0, waypoints=NOTHING)
        if task.line_id != state.line_id:
            waypoints, covered_m = self._waypoints(task.line, task.s_m)
            state = msgspec.structs.replace(
                state,
                line_id=task.line_id,
                waypoints=waypoints,
                check=PathCheck(),
                covered_m=covered_m,
            )
        state = self._look(state, ego, world, task)
        return self._path(state, ego, world, task)

    def _waypoints(self, line: ReferenceLine, s_m: float) -> tuple[Waypoints, float]:
        """(the waypoints along a line from s_m on, how far they can be driven)."""
        if self.recorded is None:
            return waypoints_from_line(line, self.waypoints), math.inf
        return waypoints_on_line(self.recorded, line, s_m, self.waypoints)

    def _look(
        self, state: WaypointPlanningState, ego: Ego, world: World, task: Task
    ) -> WaypointPlanningState:
        """Sweep the path again when there is a new scan, or when the last look is some ticks old."""
        if world.detections_stamp_ns == state.check.seen_ns and state.ticks % self.look_every:
            return state
        check = self._check(state, ego, world, task)
        allowed_mps = self.obstacle.allowed_mps(check.free_m)
        yielding, clear = self.patience.waits(state, check.free_m, allowed_mps)
        return msgspec.structs.replace(state, check=check, yielding=yielding, clear=clear)

    def _check(self, state: WaypointPlanningState, ego: Ego, world: World, task: Task) -> PathCheck:
        rule, points, kerbs = self.obstacle, world.points_map, world.points_map[:0]
        if len(world.is_low) == len(points):
            points, kerbs = points[~world.is_low], points[world.is_low]
        check_m = rule.check_m(max(self.waypoints.speed_mps_max, ego.speed_mps))
        beside_m = math.inf
        if rule.along == "arc":
            arc = sweep_arc(ego.pose_map, ego.steer_rad, rule.wheelbase_m, check_m)
            free_m = rule.free_m(points, arc, rule.clearance_m)
            free_m = min(free_m, rule.free_m(kerbs, arc, rule.low_clearance_m))
        else:
            waypoints = state.waypoints
            line = sweep_line(waypoints.points_map, waypoints.s_m, task.s_m, task.d_m, check_m)
            near_m = rule.arc_m + rule.arc_time_s * max(0.0, ego.speed_mps)
            arc = sweep_arc(ego.pose_map, ego.steer_rad, rule.wheelbase_m, near_m)
            free_m = min(
                rule.free_m(points, line, rule.clearance_m), rule.free_m(points, arc, rule.side_clearance_m)
            )
            free_m = min(free_m, rule.free_m(kerbs, line, rule.low_clearance_m))
            beside_m = rule.free_m(points, line, rule.passing_clearance_m)
        free_m = free_m if free_m <= check_m else math.inf
        return PathCheck(world.detections_stamp_ns, state.odometer_m, free_m, beside_m)

    def _path(
        self, state: WaypointPlanningState, ego: Ego, world: World, task: Task
    ) -> tuple[Path, WaypointPlanningState]:
        since_m = state.odometer_m - state.check.odometer_m
        free_m = max(0.0, state.check.free_m - since_m)
        commands = self._commands(state, ego, world, task, free_m)
        if self.signs is not None and (world.signs or state.signs.sign_id):
            for_signs, signs = self.signs.step(
                state.signs, world, state.waypoints, task, ego, self.approach, free_m
            )
            commands += for_signs
            state = msgspec.structs.replace(state, signs=signs)
        return path_along(state.waypoints, ego, task, lowest(commands), free_m, self.ahead_m), state

    def _commands(
        self, state: WaypointPlanningState, ego: Ego, world: World, task: Task, free_m: float
    ) -> list[SpeedCommand]:
        decel_mps2 = self.approach.decel_mps2
        commands = [
            cruise(state.waypoints, task.s_m, ego.speed_mps, self.delay_s),
            self.approach.command(task.stop_s_m - task.s_m, ego.speed_mps, stop_reason(task)),
            *standing_commands(task, decel_mps2),
        ]
        if task.stop_s_m > state.covered_m and ego.speed_mps < _STANDING_MPS:
            commands.append(SpeedCommand("no_plan", 0.0, -decel_mps2))
        obstacle = self.obstacle.command(free_m)
        if obstacle is not None:
            commands.append(obstacle)
        if state.yielding:
            commands.append(SpeedCommand("obstacle", 0.0, -decel_mps2))
        if state.check.beside_m < ego.speed_mps * self.obstacle.passing_time_s:
            commands.append(SpeedCommand("passing", self.obstacle.passing_mps))
        first = max(0, int(np.searchsorted(state.waypoints.s_m, task.s_m)) - 1)
        lead = self.gap.lead(
            state.waypoints.points_map, state.waypoints.s_m, task.s_m, first, world.fleet_vehicles
        )
        gap = self.gap.command(lead)
        if gap is not None:
            commands.append(gap)
        return commands + uncertainty_commands(ego, world, decel_mps2)


def cruise(waypoints: Waypoints, s_m: float, speed_mps: float, delay_s: float) -> SpeedCommand:
    """The waypoints' speed where the vehicle will be when the actuators answer."""
    s, v = waypoints.s_m, waypoints.speeds_mps
    ahead_m = s_m + delay_s * speed_mps
    wanted_mps = float(np.interp(ahead_m, s, v))
    i = min(max(int(np.searchsorted(s, ahead_m, side="right")) - 1, 0), len(s) - 2)
    slope_1ps = float((v[i + 1] - v[i]) / max(s[i + 1] - s[i], 1e-6))
    return SpeedCommand("waypoint_speed", wanted_mps, min(0.0, wanted_mps * slope_1ps))
