"""The NUS stack's planning: a rolling cost map, and the lowest of the safe speeds (NUS, section IV-B)."""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from contract.roads.areas import AreaAhead, areas_ahead, outline_array
from contract.roads.network import RoadNetwork
from vehicle_agent.planning.cost_map.cost_map import (
    CELL_M,
    CostMap,
    CostRules,
    obstacle_cells,
)
from vehicle_agent.planning.cost_map.crossings import CrossingRule, CrossingState
from vehicle_agent.planning.cost_map.safe_speeds import SafeSpeeds
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
from vehicle_agent.planning.waypoint.obstacle import first_contact, poses_on_line
from vehicle_agent.planning.waypoint.selector import SpeedCommand, lowest
from vehicle_agent.planning.waypoint.waypoints import WaypointRules, waypoints_from_line
from vehicle_agent.signals import Ego, Path, PedestrianPresence, PlanAnswer, PlanJob, Task, World


class PathCheck(msgspec.Struct, frozen=True):
    """The last look ahead: at which scan and odometer, how far the bumper could go, and the mean cost."""

    seen_ns: int = -1
    odometer_m: float = 0.0
    free_m: float = math.inf
    mean_cost: float = 0.0


class CostMapPlanningState(WaypointState, frozen=True, kw_only=True):
    """What planning remembers.

    areas     the passes through observation areas along the line; passing: how the next one stands
    """

    costs: CostMap
    areas: tuple[AreaAhead, ...] = ()
    passing: CrossingState = CrossingState()
    check: PathCheck = PathCheck()


class CostMapPlanning(msgspec.Struct, frozen=True):
    """Parameters. The cart's body in m from the rear axle; `eye_m`: the lidar ahead of it.

    sweep_m       how far the swept body is looked along for obstacles
    clearance_m   by which it is widened on each side; more than half a cell
    standoff_m    the bumper stops this far before an obstacle
    emergency_m   an obstacle nearer than this is braked for as hard as the cart can
    curve_m       how far ahead the path's curve counts as steering already
    """

    network: RoadNetwork
    body_front_m: float
    body_back_m: float
    half_width_m: float
    wheelbase_m: float
    eye_m: float
    gap: GapRule
    waypoints: WaypointRules = WaypointRules(2.0)
    cost_rules: CostRules = CostRules()
    speeds: SafeSpeeds = SafeSpeeds()
    crossings: CrossingRule = CrossingRule()
    approach: Approach = Approach()
    patience: ResumeRule = ResumeRule(resume_m=4.0)
    sweep_m: float = 10.0
    clearance_m: float = 0.3
    side_clearance_m: float = 0.15
    standoff_m: float = 2.0
    emergency_m: float = 1.2
    curve_m: float = 3.0
    look_every: int = 5
    ahead_m: float = 20.0

    def initial(self) -> CostMapPlanningState:
        return CostMapPlanningState(costs=self.cost_rules.empty())

    def jobs(self, state: CostMapPlanningState) -> tuple[PlanJob, ...]:
        return ()

    def step(
        self,
        state: CostMapPlanningState,
        ego: Ego,
        world: World,
        task: Task,
        plans: tuple[PlanAnswer, ...] = (),
    ) -> tuple[Path, CostMapPlanningState]:
        """The waypoints ahead and the speed to follow now.

        Without a line the vehicle stands. It needs no planner.
        """
        state = next_tick(state, ego)
        if task.line is None:
            return no_path(ego), msgspec.structs.replace(state, line_id=0, waypoints=NOTHING, areas=())
        if task.line_id != state.line_id:
            state = msgspec.structs.replace(
                state,
                line_id=task.line_id,
                waypoints=waypoints_from_line(task.line, self.waypoints),
                areas=areas_ahead(self.network, task.line),
                passing=CrossingState(),
                check=PathCheck(),
            )
        is_new = world.detections_stamp_ns not in (0, state.check.seen_ns)
        if is_new or state.ticks % self.look_every == 0:
            state = self._look(state, ego, world, task, is_new)
        return self._path(state, ego, world, task), state

    def _look(
        self, state: CostMapPlanningState, ego: Ego, world: World, task: Task, is_new: bool
    ) -> CostMapPlanningState:
        """Bring the map up to date with the scan, and look along the swept body."""
        pose, costs = ego.pose_map, state.costs
        if is_new:
            eye = np.array(
                [
                    pose.x_m + self.eye_m * math.cos(pose.yaw_rad),
                    pose.y_m + self.eye_m * math.sin(pose.yaw_rad),
                ]
            )
            costs = self.cost_rules.updated(costs, pose.x_m, pose.y_m, eye, world.points_map)
        check = self._check(state, costs, ego, world, task)
        yielding, clear = self.patience.waits(state, check.free_m, self._obstacle_mps(check.free_m))
        passing = self._passing(state, costs, ego, world, task)
        return msgspec.structs.replace(
            state, costs=costs, check=check, yielding=yielding, clear=clear, passing=passing
        )

    def _check(
        self, state: CostMapPlanningState, costs: CostMap, ego: Ego, world: World, task: Task
    ) -> PathCheck:
        waypoints, pose = state.waypoints, ego.pose_map
        poses, travelled = poses_on_line(
            waypoints.points_map, waypoints.s_m, task.s_m, task.d_m, self.sweep_m, 0.5
        )
        near = obstacle_cells(
            costs.cells, costs.column, costs.row, pose.x_m, pose.y_m, self.sweep_m + self.body_front_m + 1.0
        )
        free_m = first_contact(
            near,
            poses,
            travelled,
            self.body_front_m,
            self.body_back_m,
            self.half_width_m,
            self.clearance_m,
            self.side_clearance_m,
        )
        fine, _ = poses_on_line(
            waypoints.points_map, waypoints.s_m, task.s_m, task.d_m, self.speeds.ahead_m, CELL_M
        )
        mean_cost = 0.0
        if costs.known:
            mean_cost = self.speeds.mean_cost(costs, fine, self.body_front_m, self.half_width_m)
        return PathCheck(world.detections_stamp_ns, state.odometer_m, float(free_m), mean_cost)

    def _obstacle_mps(self, free_m: float) -> float:
        return math.sqrt(2.0 * self.approach.decel_mps2 * max(free_m - self.standoff_m, 0.0))

    def _next_area(self, state: CostMapPlanningState, task: Task) -> tuple[int, AreaAhead] | None:
        """The first pass whose area the cart's tail has not left yet."""
        tail_s_m = task.s_m - self.body_back_m
        for number, area in enumerate(state.areas):
            if area.leave_s_m > tail_s_m:
                return number, area
        return None

    def _stop_m(self, area: AreaAhead, task: Task) -> float:
        return area.stop_s_m - self.body_front_m - task.s_m

    def _passing(
        self, state: CostMapPlanningState, costs: CostMap, ego: Ego, world: World, task: Task
    ) -> CrossingState:
        found = self._next_area(state, task)
        if found is None or found[1].kind != "crossing" or self.crossings.stops == "never":
            return CrossingState()
        number, area = found
        outline = self._outline(area.area_id)
        reported, stop_m = _reported(world, area.area_id), self._stop_m(area, task)
        return self.crossings.observe(
            state.passing, number, area, outline, costs, reported, stop_m, ego.speed_mps
        )

    def _outline(self, area_id: str) -> Array:
        areas = self.network.road_map.observation_areas
        return next(outline_array(area) for area in areas if area.area_id == area_id)

    def _path(self, state: CostMapPlanningState, ego: Ego, world: World, task: Task) -> Path:
        since_m = state.odometer_m - state.check.odometer_m
        free_m = max(0.0, state.check.free_m - since_m)
        command = lowest(self._commands(state, ego, world, task, free_m))
        return path_along(state.waypoints, ego, task, command, free_m, self.ahead_m)

    def _commands(
        self, state: CostMapPlanningState, ego: Ego, world: World, task: Task, free_m: float
    ) -> list[SpeedCommand]:
        decel_mps2 = self.approach.decel_mps2
        limit_mps = float(np.interp(task.s_m, state.waypoints.s_m, state.waypoints.speeds_mps))
        commands = [
            SpeedCommand("waypoint_speed", limit_mps),
            self.speeds.by_steering(self._steer_rad(ego, task)),
            self.speeds.by_cost(state.check.mean_cost),
            self.approach.command(task.stop_s_m - task.s_m, ego.speed_mps, stop_reason(task)),
            *standing_commands(task, decel_mps2),
        ]
        if not math.isinf(free_m):
            command = self.approach.command(free_m - self.standoff_m, ego.speed_mps, "obstacle")
            is_near = free_m < self.emergency_m
            commands.append(msgspec.structs.replace(command, emergency=is_near))
        if state.yielding:
            commands.append(SpeedCommand("obstacle", 0.0, -decel_mps2))
        commands += self._road_user_commands(state, ego, world, task)
        return commands + uncertainty_commands(ego, world, decel_mps2)

    def _road_user_commands(
        self, state: CostMapPlanningState, ego: Ego, world: World, task: Task
    ) -> list[SpeedCommand]:
        """For the fleet vehicle ahead, and for people that a camera reports."""
        points, s = state.waypoints.points_map, state.waypoints.s_m
        first = max(0, int(np.searchsorted(s, task.s_m)) - 1)
        gap = self.gap.command(self.gap.lead(points, s, task.s_m, first, world.fleet_vehicles))
        found = self._next_area(state, task)
        crossing = None
        if found is not None:
            area, stop_m = found[1], self._stop_m(found[1], task)
            passing = state.passing if area.kind == "crossing" else CrossingState(spared=True)
            crossing = self.crossings.command(
                passing, _reported(world, area.area_id), stop_m, ego.speed_mps, self.approach
            )
        return [command for command in (gap, crossing) if command is not None]

    def _steer_rad(self, ego: Ego, task: Task) -> float:
        """The larger of the angle steered and that which the path's curve will need within `curve_m`."""
        assert task.line is not None
        line = task.line
        first, last = np.searchsorted(line.s, [task.s_m, task.s_m + self.curve_m])
        bends = np.abs(line.curvature_1pm[first : last + 1])
        needed_rad = math.atan(self.wheelbase_m * float(bends.max())) if len(bends) else 0.0
        return max(abs(ego.steer_rad), needed_rad)


def _reported(world: World, area_id: str) -> PedestrianPresence | None:
    """The camera's report on the area, if it is not stale."""
    return next((word for word in world.presence if word.area_id == area_id), None)
