"""Following waypoints at the lowest of several speed commands: shared by the GEM and the NUS stack."""

import math
from typing import TypeVar

import msgspec
import numpy as np

from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.waypoint.selector import SpeedCommand
from vehicle_agent.planning.waypoint.waypoints import Waypoints
from vehicle_agent.signals import Ego, Path, Task, World
from vehicle_agent.signals.poor_position import position_limit_mps

NOTHING = Waypoints(np.empty((0, 2)), np.empty(0), np.empty(0))


class WaypointState(msgspec.Struct, frozen=True):
    """What is remembered of the way.

    yielding  standing, or stopping, for an obstacle in the path
    clear     observations in a row that found it free again
    """

    line_id: int = 0
    waypoints: Waypoints = NOTHING
    stamp_ns: int = 0
    odometer_m: float = 0.0
    ticks: int = 0
    yielding: bool = False
    clear: int = 0


class ResumeRule(msgspec.Struct, frozen=True):
    """No creeping: below yield_mps the vehicle stands, until the path has been free for resume_m in
    clear_looks observations in a row.
    """

    yield_mps: float = 0.3
    resume_m: float = 8.0
    clear_looks: int = 8

    def waits(self, state: WaypointState, free_m: float, allowed_mps: float) -> tuple[bool, int]:
        """(yielding, clear) after a look that found free_m, and allowed_mps by it."""
        if not state.yielding:
            return allowed_mps < self.yield_mps, 0
        clear = state.clear + 1 if free_m > self.resume_m else 0
        return clear < self.clear_looks, clear


def uncertainty_commands(ego: Ego, world: World, decel_mps2: float) -> list[SpeedCommand]:
    """Commands for an unknown or poor position and for blind sensors."""
    commands = []
    limit_mps = position_limit_mps(ego.position_std_m)
    if not ego.valid:
        commands.append(SpeedCommand("no_position", 0.0, -decel_mps2))
    elif math.isfinite(limit_mps):
        commands.append(SpeedCommand("poor_position", limit_mps))
    if world.blind:
        commands.append(SpeedCommand("blind", 0.0, -decel_mps2))
    return commands


State = TypeVar("State", bound=WaypointState)


def next_tick(state: State, ego: Ego) -> State:
    """A tick later."""
    travelled_m = abs(ego.speed_mps) * (ego.stamp_ns - state.stamp_ns) * 1e-9 if state.stamp_ns else 0.0
    return msgspec.structs.replace(
        state, stamp_ns=ego.stamp_ns, odometer_m=state.odometer_m + travelled_m, ticks=state.ticks + 1
    )


def no_path(ego: Ego) -> Path:
    """Without a line: stand still."""
    return Path(ego.stamp_ns, NOTHING.points_map, NOTHING.speeds_mps, 0.0, "no_order", None, 0.0, False)


def path_along(
    waypoints: Waypoints, ego: Ego, task: Task, command: SpeedCommand, free_m: float, ahead_m: float
) -> Path:
    """The waypoints of the next ahead_m, and the command to obey; free_m may be inf."""
    ahead = waypoints.ahead(task.s_m, ahead_m)
    return Path(
        stamp_ns=ego.stamp_ns,
        points_map=waypoints.points_map[ahead],
        speeds_mps=waypoints.speeds_mps[ahead],
        speed_mps=command.speed_mps,
        limited_by=command.name,
        obstacle_m=None if math.isinf(free_m) else free_m,
        stop_m=task.stop_s_m - task.s_m,
        emergency=command.emergency and ego.speed_mps > 0.05,
        accel_mps2=command.accel_mps2,
    )


def stop_reason(task: Task) -> SpeedLimitReason:
    """The reason for the task's stop."""
    if task.mode != "drive":
        return task.mode
    if task.waiting_for:
        return "section"
    return "stop_occupied" if task.reason == "stop_occupied" else "stop"


def standing_commands(task: Task, decel_mps2: float) -> list[SpeedCommand]:
    """While there is nothing to drive to, or riders get on and off."""
    return [SpeedCommand(task.mode, 0.0, -decel_mps2)] if task.mode in ("dwell", "idle") else []
