"""Stop and yield signs beside the way: where they stop the vehicle, and for how long (GEM, section VI)."""

import math

import msgspec

from contract.geometry import pose_at, project, wrap_angle
from vehicle_agent.planning.waypoint.approach import Approach
from vehicle_agent.planning.waypoint.selector import SpeedCommand
from vehicle_agent.planning.waypoint.waypoints import Waypoints
from vehicle_agent.signals import Ego, SeenSign, Task, World

_STANDING_MPS = 0.05


class SignMemory(msgspec.Struct, frozen=True):
    """What is remembered of signs.

    sign_id      that is obeyed now, 0 for none; decel_mps2: with which
    standing_ns  since when the vehicle has stood before it, 0 while it does not
    served       ids of the signs at which it has stood, as long as they are known
    """

    sign_id: int = 0
    decel_mps2: float = 0.0
    standing_ns: int = 0
    served: tuple[int, ...] = ()


class SignAhead(msgspec.Struct, frozen=True):
    """A sign for this way; gap_m: from the front bumper to where it has to stand, negative beyond."""

    sign: SeenSign
    gap_m: float


class SignRule(msgspec.Struct, frozen=True):
    """a = -v^2 / 2d from where the sign was named: 0.45 m/s2 for 3 m/s and 10 m (GEM, section VI).

    side             signs stand on this side of the way: the kerb's
    ahead_m          farther signs are left alone
    aside_m          least and greatest distance of a sign from the line
    facing_rad_max   between the board's normal and the way back along the line: other signs are for others
    before_m         the bumper stands so far before the board
    passed_m         a bumper this far beyond has passed the sign
    stand_s          it stands for so long, so near to the place, and then goes on when the path is free
    resume_m         free path for that
    decel_mps2_min   an early named sign does not make the vehicle creep
    decel_mps2_max   the hardest braking for a sign that is named late
    yield_mps        past a yield sign
    """

    body_front_m: float
    side: str = "right"
    ahead_m: float = 32.0
    aside_m: tuple[float, float] = (0.8, 6.5)
    facing_rad_max: float = 0.6
    before_m: float = 1.0
    passed_m: float = 2.5
    stand_s: float = 2.0
    resume_m: float = 8.0
    decel_mps2_min: float = 0.45
    decel_mps2_max: float = 2.5
    yield_mps: float = 1.5

    def ahead(self, signs: tuple[SeenSign, ...], waypoints: Waypoints, task: Task) -> tuple[SignAhead, ...]:
        """The stop and yield signs for this way, nearest first."""
        points, s = waypoints.points_map, waypoints.s_m
        if len(s) < 2:
            return ()
        first = max(0, int(s.searchsorted(task.s_m)) - 2)
        last = int(s.searchsorted(task.s_m + self.ahead_m + self.body_front_m))
        found = []
        for sign in signs:
            if sign.kind not in ("stop", "yield"):
                continue
            pose = sign.pose_map
            along_m, left_m, _ = project(points, s, pose.x_m, pose.y_m, first, last)
            aside_m = left_m if self.side == "left" else -left_m
            _, _, yaw = pose_at(points, s, along_m)
            faces = abs(wrap_angle(pose.yaw_rad - yaw - math.pi)) <= self.facing_rad_max
            gap_m = along_m - self.before_m - self.body_front_m - task.s_m
            if faces and self.aside_m[0] <= aside_m <= self.aside_m[1] and gap_m >= -self.passed_m:
                found.append(SignAhead(sign, gap_m))
        return tuple(sorted(found, key=lambda one: one.gap_m))

    def step(
        self,
        memory: SignMemory,
        world: World,
        waypoints: Waypoints,
        task: Task,
        ego: Ego,
        approach: Approach,
        free_m: float,
    ) -> tuple[list[SpeedCommand], SignMemory]:
        """The commands for the signs ahead; free_m: of the path."""
        known = {sign.sign_id for sign in world.signs}
        memory = msgspec.structs.replace(
            memory, served=tuple(sign_id for sign_id in memory.served if sign_id in known)
        )
        ahead = [
            one for one in self.ahead(world.signs, waypoints, task) if one.sign.sign_id not in memory.served
        ]
        commands = [self._slow(one, ego) for one in ahead if one.sign.kind == "yield"]
        stops = [one for one in ahead if one.sign.kind == "stop"]
        if not stops:
            return commands, msgspec.structs.replace(memory, sign_id=0, standing_ns=0)
        stop, memory = stops[0], self._obeyed(memory, stops[0], ego)
        if memory.sign_id in memory.served:
            return commands, memory
        braking = msgspec.structs.replace(approach, decel_mps2=memory.decel_mps2)
        commands.append(braking.command(stop.gap_m, ego.speed_mps, "stop_sign"))
        stands = abs(ego.speed_mps) < _STANDING_MPS and abs(stop.gap_m) <= self.passed_m
        if not stands:
            return commands, msgspec.structs.replace(memory, standing_ns=0)
        since_ns = memory.standing_ns or ego.stamp_ns
        has_stood = ego.stamp_ns - since_ns >= round(self.stand_s * 1e9)
        served = (
            (*memory.served, stop.sign.sign_id) if has_stood and free_m >= self.resume_m else memory.served
        )
        return commands, msgspec.structs.replace(memory, standing_ns=since_ns, served=served)

    def _obeyed(self, memory: SignMemory, stop: SignAhead, ego: Ego) -> SignMemory:
        """The deceleration is set when a sign is first named."""
        if memory.sign_id == stop.sign.sign_id:
            return memory
        needed = ego.speed_mps**2 / (2.0 * max(stop.gap_m, 0.1))
        decel = min(max(needed, self.decel_mps2_min), self.decel_mps2_max)
        return msgspec.structs.replace(memory, sign_id=stop.sign.sign_id, decel_mps2=decel, standing_ns=0)

    def _slow(self, one: SignAhead, ego: Ego) -> SpeedCommand:
        """Slower before a yield sign, so that the obstacle rule can stop for what crosses."""
        free_m = max(one.gap_m, 0.0)
        allowed_mps = math.sqrt(self.yield_mps**2 + 2.0 * self.decel_mps2_min * free_m)
        slope_mps2 = -self.decel_mps2_min if ego.speed_mps > self.yield_mps else 0.0
        braking = slope_mps2 if allowed_mps <= ego.speed_mps + 0.1 else 0.0
        return SpeedCommand("yield_sign", allowed_mps, braking)
