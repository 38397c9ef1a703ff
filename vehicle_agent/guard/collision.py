"""How hard to brake for whoever is about to be touched: not at all, just enough, or fully."""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.guard.imminence import anybody_within, will_touch
from vehicle_agent.guard.others import rows_of_mates, rows_of_points, rows_of_tracks
from vehicle_agent.signals import Ego, VehicleMotion, World

# So much of the flank goes with the bumper: who stands there can still step before it.
_CORNER_M = 0.3


class Avoidance(msgspec.Struct, frozen=True):
    """The vehicle's outline from the rear axle, its own response and braking, and the room it keeps.

    response_s, brake_mps2  what a collision must not need: driving on for so long, then braking so hard
    delay_s                 from a pedal to its effect
    brakes                  (deceleration, pedal) to choose from, mildest first; then the full pedal
    release_s               once it brakes, so much more response time must be free before it lets go
    front_margin_m, margin_m  room before the bumper beyond that on every side
    set_off_mps             a standing vehicle must be free at this speed to set off
    """

    wheelbase_m: float
    back_m: float
    front_m: float
    half_width_m: float
    brakes: tuple[tuple[float, float], ...]
    accel_mps2_max: float = 0.8
    response_s: float = 0.3
    brake_mps2: float = 5.0
    delay_s: float = 0.25
    release_s: float = 0.2
    front_margin_m: float = 0.2
    margin_m: float = 0.1
    set_off_mps: float = 0.5
    within_m: float = 20.0

    @property
    def body(self) -> tuple[float, float, float]:
        return (self.back_m, self.front_m, self.half_width_m)

    def others(self, world: World, ego: Ego) -> tuple[Array, Array]:
        """(everybody who moves, the same and what stands), rows in the base frame; see `others`."""
        pose, now_ns = ego.pose_map, ego.stamp_ns
        movers = np.vstack(
            (
                rows_of_tracks(world.tracks, pose, now_ns, self.within_m),
                rows_of_mates(world.others, pose, now_ns, self.body),
            )
        )
        everything = np.vstack((movers, rows_of_points(world.points_map, pose, self.within_m)))
        return movers, everything[np.isfinite(everything).all(axis=1)]

    def brake_ratio(
        self, rows: Array, ego: Ego, motion: VehicleMotion, steer_rad: float, speed_mps: float, braking: bool
    ) -> float:
        """The pedal that is needed now on the commanded and on the actual steering angle, 0 for none."""
        accel = min(max(ego.accel_mps2, 0.0), self.accel_mps2_max)
        response_s = self.response_s + (self.release_s if braking else 0.0)
        curvatures = {math.tan(angle) / self.wheelbase_m for angle in (steer_rad, motion.steer_rad)}
        return max(self._pedal(rows, curvature, speed_mps, accel, response_s) for curvature in curvatures)

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
        """It rolls as slowly as it sets off, and somebody in the margins of its bumper may go first."""
        corner_m = self.front_m - _CORNER_M
        return speed_mps < self.set_off_mps and bool(
            anybody_within(movers, self.body, self.front_margin_m, self.margin_m, corner_m)
        )

    def may_set_off(self, movers: Array, rows: Array, steer_rad: float) -> bool:
        """Nobody is in the footprint and its margins, and nothing is met at once; driving on leaves whoever
        is behind it behind."""
        if anybody_within(movers, self.body, self.front_margin_m, self.margin_m, -self.back_m):
            return False
        curvature_1pm = math.tan(steer_rad) / self.wheelbase_m
        return not self._touches(
            rows, curvature_1pm, self.set_off_mps, 0.0, self.response_s, self.brake_mps2, self.front_margin_m
        )
