"""How hard to brake to avoid a contact: not at all, just enough, or fully."""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.guard.imminence import is_any_within, nearest_beside_m, will_touch
from vehicle_agent.guard.road_users import rows_of_fleet_vehicles, rows_of_points, rows_of_tracks
from vehicle_agent.signals import Ego, VehicleMotion, World

# A person this far behind the bumper can still step in front of it.
_CORNER_M = 0.3


class Avoidance(msgspec.Struct, frozen=True):
    """The vehicle's outline from the rear axle, its response and braking, and the margins it keeps.

    response_s, brake_mps2  assumed response: the vehicle drives on for response_s, then brakes at brake_mps2
    delay_s                 from a pedal command to its effect
    brakes                  (deceleration, pedal) to choose from, mildest first; then the full pedal
    release_s               a braking vehicle releases the brake only with this much more response time free
    front_margin_m, margin_m  extra room ahead of the bumper; room on every side
    set_off_mps             a standing vehicle must be free at this speed to set off
    beside_m, touching_mps  a person nearer to the flank than beside_m allows touching_mps at no distance, and
                            full_mps at beside_m
    within_m                road users and obstacles farther away are ignored
    """

    wheelbase_m: float
    back_m: float
    front_m: float
    half_width_m: float
    brakes: tuple[tuple[float, float], ...]
    accel_mps2_max: float
    delay_s: float
    response_s: float = 0.3
    brake_mps2: float = 5.0
    release_s: float = 0.2
    front_margin_m: float = 0.2
    margin_m: float = 0.1
    set_off_mps: float = 0.5
    beside_m: float = 0.4
    touching_mps: float = 1.2
    full_mps: float = 4.2
    within_m: float = 20.0

    @property
    def body(self) -> tuple[float, float, float]:
        return (self.back_m, self.front_m, self.half_width_m)

    def road_users(self, world: World, ego: Ego) -> tuple[Array, Array]:
        """(road users, the same and the obstacle cells): rows in the base frame, as in `road_users`."""
        pose, now_ns = ego.pose_map, ego.stamp_ns
        movers = np.vstack(
            (
                rows_of_tracks(world.tracks, pose, now_ns, self.within_m),
                rows_of_fleet_vehicles(world.fleet_vehicles, pose, now_ns, self.body),
            )
        )
        obstacles = np.vstack((movers, rows_of_points(world.points_map, pose, self.within_m)))
        return movers, obstacles[np.isfinite(obstacles).all(axis=1)]

    def brake_ratio(
        self, rows: Array, ego: Ego, motion: VehicleMotion, steer_rad: float, speed_mps: float, braking: bool
    ) -> float:
        """The brake pedal needed now, on the commanded and on the actual steering angle; 0 for none."""
        accel = min(max(ego.accel_mps2, 0.0), self.accel_mps2_max)
        # More response time takes the vehicle farther: before somebody, or past them. A braking vehicle that
        # would just get past now would not after another tick of braking, so both must be free.
        responses_s = (self.response_s, self.response_s + self.release_s) if braking else (self.response_s,)
        curvatures = {math.tan(angle) / self.wheelbase_m for angle in (steer_rad, motion.steer_rad)}
        return max(
            self._pedal(rows, curvature, speed_mps, accel, response_s)
            for curvature in curvatures
            for response_s in responses_s
        )

    def _pedal(
        self, rows: Array, curvature_1pm: float, speed_mps: float, accel_mps2: float, response_s: float
    ) -> float:
        if not self._touches(
            rows, curvature_1pm, speed_mps, accel_mps2, response_s, self.brake_mps2, self.front_margin_m
        ):
            return 0.0
        for decel_mps2, ratio in self.brakes:
            if not self._touches(
                rows,
                curvature_1pm,
                speed_mps,
                accel_mps2,
                self.delay_s,
                decel_mps2,
                0.5 * self.front_margin_m,
            ):
                return ratio
        return 1.0

    def _touches(
        self,
        rows: Array,
        curvature_1pm: float,
        speed_mps: float,
        accel_mps2: float,
        response_s: float,
        decel_mps2: float,
        front_margin_m: float,
    ) -> bool:
        return bool(
            will_touch(
                rows,
                curvature_1pm,
                speed_mps,
                accel_mps2,
                response_s,
                decel_mps2,
                self.body,
                front_margin_m,
                self.margin_m,
            )
        )

    def is_creeping_up(self, movers: Array, speed_mps: float) -> bool:
        """The vehicle rolls no faster than it sets off, and a road user is within the bumper's margins."""
        corner_m = self.front_m - _CORNER_M
        return speed_mps < self.set_off_mps and bool(
            is_any_within(movers, self.body, self.front_margin_m, self.margin_m, corner_m)
        )

    def alongside_mps(self, movers: Array) -> float:
        """The speed allowed beside people and cyclists at the flanks, inf without any.

        Not a stop: it would not help them, and they walk on along a vehicle that stands. But whoever stumbles
        or turns at arm's length meets a slow vehicle. Those who are ahead of the bumper are no such people.
        """
        gap_m = nearest_beside_m(movers, self.body)
        if gap_m >= self.beside_m:
            return math.inf
        return self.touching_mps + (self.full_mps - self.touching_mps) * max(gap_m, 0.0) / self.beside_m

    def may_set_off(self, movers: Array, rows: Array, steer_rad: float) -> bool:
        """No road user is before the bumper or touches a flank, and nothing is touched at once.

        Road users behind the rear bumper do not count: driving on moves away from them. So it does from who
        is near a flank, unless the vehicle turns towards them.
        """
        corner_m = self.front_m - _CORNER_M
        if is_any_within(movers, self.body, self.front_margin_m, self.margin_m, corner_m):
            return False
        if is_any_within(movers, self.body, 0.0, 0.0, -self.back_m):
            return False
        curvature_1pm = math.tan(steer_rad) / self.wheelbase_m
        return not self._touches(
            rows, curvature_1pm, self.set_off_mps, 0.0, self.response_s, self.brake_mps2, self.front_margin_m
        )
