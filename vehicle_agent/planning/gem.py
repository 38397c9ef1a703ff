"""The GEM stack's planning: waypoints to follow, and the lowest of all speed commands (GEM, section II)."""

import math

import msgspec
import numpy as np

from vehicle_agent.planning.approach import Approach
from vehicle_agent.planning.gap import GapRule
from vehicle_agent.planning.obstacle import ObstacleRule, sweep_arc, sweep_line
from vehicle_agent.planning.selector import SpeedCommand, lowest
from vehicle_agent.planning.waypoints import WaypointRules, Waypoints, waypoints_from_line
from vehicle_agent.signals import Ego, Path, PlanAnswer, PlanJob, Task, World

_NOTHING = Waypoints(np.empty((0, 2)), np.empty(0), np.empty(0))


class Looked(msgspec.Struct, frozen=True):
    """The last look along the path: at which scan and place, and how far the bumper could go.

    beside_m  distance to the nearest thing just beside the path
    """

    seen_ns: int = -1
    odometer_m: float = 0.0
    free_m: float = math.inf
    beside_m: float = math.inf


class Plan(msgspec.Struct, frozen=True):
    """What planning remembers.

    yielding  standing, or coming to a stand, for somebody in the path
    clear     looks in a row that found the path free again
    """

    line_id: int = 0
    waypoints: Waypoints = _NOTHING
    stamp_ns: int = 0
    odometer_m: float = 0.0
    looked: Looked = Looked()
    ticks: int = 0
    yielding: bool = False
    clear: int = 0


class WaypointPlanning(msgspec.Struct, frozen=True):
    """Parameters of every speed command.

    look_every      ticks between looks along the path when no new scan comes
    yield_mps       an obstacle that leaves less than this is waited for: nobody is crept at
    resume_m        the path must be free this far
    clear_looks     for so many looks in a row before the vehicle goes on
    poor_std_m      above this position deviation the vehicle goes at most poor_mps (Snow Lion, 0.5 m/s)
    delay_s         how far ahead in time speeds are read from the waypoints
    """

    waypoints: WaypointRules
    obstacle: ObstacleRule
    gap: GapRule
    approach: Approach = Approach()
    look_every: int = 5
    yield_mps: float = 0.3
    resume_m: float = 8.0
    clear_looks: int = 8
    poor_std_m: float = 0.3
    poor_mps: float = 0.5
    delay_s: float = 0.25
    ahead_m: float = 30.0

    def initial(self) -> Plan:
        return Plan()

    def jobs(self, state: Plan) -> tuple[PlanJob, ...]:
        return ()

    def step(
        self, state: Plan, ego: Ego, world: World, task: Task, plans: tuple[PlanAnswer, ...] = ()
    ) -> tuple[Path, Plan]:
        """The waypoints ahead and the speed to obey now. Without a line: stand still. Nobody plans for it."""
        travelled_m = abs(ego.speed_mps) * (ego.stamp_ns - state.stamp_ns) * 1e-9 if state.stamp_ns else 0.0
        state = msgspec.structs.replace(
            state, stamp_ns=ego.stamp_ns, odometer_m=state.odometer_m + travelled_m, ticks=state.ticks + 1
        )
        if task.line is None:
            path = Path(
                ego.stamp_ns, _NOTHING.points_map, _NOTHING.speeds_mps, 0.0, "no order", None, 0.0, False
            )
            return path, msgspec.structs.replace(state, line_id=0, waypoints=_NOTHING)
        if task.line_id != state.line_id:
            state = msgspec.structs.replace(
                state,
                line_id=task.line_id,
                waypoints=waypoints_from_line(task.line, self.waypoints),
                looked=Looked(),
            )
        state = self._look(state, ego, world, task)
        return self._path(state, ego, world, task), state

    def _look(self, state: Plan, ego: Ego, world: World, task: Task) -> Plan:
        """Sweep the path again when there is a new scan, or when the last look is some ticks old."""
        if world.seen_stamp_ns == state.looked.seen_ns and state.ticks % self.look_every:
            return state
        looked = self._looked(state, ego, world, task)
        allowed_mps = self.obstacle.allowed_mps(looked.free_m)
        if not state.yielding:
            yielding = allowed_mps < self.yield_mps
            return msgspec.structs.replace(state, looked=looked, yielding=yielding, clear=0)
        clear = state.clear + 1 if looked.free_m > self.resume_m else 0
        return msgspec.structs.replace(state, looked=looked, clear=clear, yielding=clear < self.clear_looks)

    def _looked(self, state: Plan, ego: Ego, world: World, task: Task) -> Looked:
        rule, points = self.obstacle, world.points_map
        check_m = rule.check_m(max(self.waypoints.speed_mps_max, ego.speed_mps))
        beside_m = math.inf
        if rule.along == "arc":
            arc = sweep_arc(ego.pose_map, ego.steer_rad, rule.wheelbase_m, check_m)
            free_m = rule.free_m(points, arc, rule.clearance_m)
        else:
            waypoints = state.waypoints
            line = sweep_line(waypoints.points_map, waypoints.s_m, task.s_m, task.d_m, check_m)
            near_m = rule.arc_m + rule.arc_time_s * max(0.0, ego.speed_mps)
            arc = sweep_arc(ego.pose_map, ego.steer_rad, rule.wheelbase_m, near_m)
            free_m = min(
                rule.free_m(points, line, rule.clearance_m), rule.free_m(points, arc, rule.side_clearance_m)
            )
            beside_m = rule.free_m(points, line, rule.passing_clearance_m)
        free_m = free_m if free_m <= check_m else math.inf
        return Looked(world.seen_stamp_ns, state.odometer_m, free_m, beside_m)

    def _path(self, state: Plan, ego: Ego, world: World, task: Task) -> Path:
        since_m = state.odometer_m - state.looked.odometer_m
        free_m = max(0.0, state.looked.free_m - since_m)
        stop_m = task.stop_s_m - task.s_m
        command = lowest(self._commands(state, ego, world, task, free_m, stop_m))
        waypoints = state.waypoints
        ahead = waypoints.ahead(task.s_m, self.ahead_m)
        return Path(
            stamp_ns=ego.stamp_ns,
            points_map=waypoints.points_map[ahead],
            speeds_mps=waypoints.speeds_mps[ahead],
            speed_mps=command.speed_mps,
            limited_by=command.name,
            obstacle_m=None if math.isinf(free_m) else free_m,
            stop_m=stop_m,
            emergency=command.emergency and ego.speed_mps > 0.05,
            accel_mps2=command.accel_mps2,
        )

    def _commands(
        self, state: Plan, ego: Ego, world: World, task: Task, free_m: float, stop_m: float
    ) -> list[SpeedCommand]:
        commands = [cruise(state.waypoints, task.s_m, ego.speed_mps, self.delay_s)]
        name = (
            task.mode
            if task.mode != "drive"
            else f"section {task.waiting_for}"
            if task.waiting_for
            else "stop"
        )
        commands.append(self.approach.command(stop_m, ego.speed_mps, name))
        if task.mode in ("dwell", "idle"):
            commands.append(SpeedCommand(task.mode, 0.0, -self.approach.decel_mps2))
        obstacle = self.obstacle.command(free_m)
        if obstacle is not None:
            commands.append(obstacle)
        if state.yielding:
            commands.append(SpeedCommand("obstacle", 0.0, -self.approach.decel_mps2))
        if state.looked.beside_m < ego.speed_mps * self.obstacle.passing_time_s:
            commands.append(SpeedCommand("passing", self.obstacle.passing_mps))
        first = max(0, int(np.searchsorted(state.waypoints.s_m, task.s_m)) - 1)
        lead = self.gap.lead(state.waypoints.points_map, state.waypoints.s_m, task.s_m, first, world.others)
        gap = self.gap.command(lead)
        if gap is not None:
            commands.append(gap)
        if not ego.valid:
            commands.append(SpeedCommand("no position", 0.0, -self.approach.decel_mps2))
        elif ego.position_std_m > self.poor_std_m:
            commands.append(SpeedCommand("poor position", self.poor_mps))
        if world.blind:
            commands.append(SpeedCommand("blind", 0.0, -self.approach.decel_mps2))
        return commands


def cruise(waypoints: Waypoints, s_m: float, speed_mps: float, delay_s: float) -> SpeedCommand:
    """The waypoints' speed where the vehicle will be when the actuators answer."""
    s, v = waypoints.s_m, waypoints.speeds_mps
    ahead_m = s_m + delay_s * speed_mps
    wanted_mps = float(np.interp(ahead_m, s, v))
    i = min(max(int(np.searchsorted(s, ahead_m, side="right")) - 1, 0), len(s) - 2)
    slope_1ps = float((v[i + 1] - v[i]) / max(s[i + 1] - s[i], 1e-6))
    return SpeedCommand("waypoints", wanted_mps, min(0.0, wanted_mps * slope_1ps))
