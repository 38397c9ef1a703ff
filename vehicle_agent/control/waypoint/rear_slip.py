"""The rear axle's slip, learned from the poses: with tyres the vehicle does not move where it points."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, wrap_angle
from vehicle_agent.signals import Ego

# Columns of the memory of poses.
_X, _Y, _YAW, _LATERAL = range(4)


class RearSlipState(msgspec.Struct, frozen=True):
    """poses (k, 4): x, y, heading and lateral acceleration of the last ticks, oldest first.

    products, squares  sums of slip times lateral acceleration, and of its square, over the time remembered
    """

    poses: Array
    products: float = 0.0
    squares: float = 0.0


class RearSlip(msgspec.Struct, frozen=True):
    """Slip angle = share x lateral acceleration; the share is a regression with a prior.

    nominal_per_mps2   the profile's tyres: the prior, worth as much as prior_s of a curve at curve_mps2
    per_mps2_max       a larger share is not of tyres
    window_s           the course is the direction from the pose of this long ago to the present one
    memory_s           older curves are forgotten, so that another load is learned
    speed_mps_min      slower, the direction between two poses is noise
    """

    nominal_per_mps2: float = 0.0
    prior_s: float = 8.0
    curve_mps2: float = 0.5
    per_mps2_max: float = 0.025
    window_s: float = 0.6
    memory_s: float = 60.0
    speed_mps_min: float = 1.0
    dt_s: float = 0.02

    def initial(self) -> RearSlipState:
        return RearSlipState(np.zeros((0, 4)))

    def per_mps2(self, state: RearSlipState) -> float:
        """Slip angle (rad) for a lateral acceleration of 1 m/s2, never negative."""
        weight = self.prior_s * self.curve_mps2**2
        share = (state.products + weight * self.nominal_per_mps2) / (state.squares + weight)
        return min(max(share, 0.0), self.per_mps2_max)

    def course_rad(self, state: RearSlipState, yaw_rad: float, speed_mps: float, turn_radps: float) -> float:
        """The direction in which the rear axle moves."""
        return yaw_rad - self.per_mps2(state) * self._dynamic(speed_mps) * speed_mps * turn_radps

    def step(self, state: RearSlipState, ego: Ego) -> RearSlipState:
        """The state after this tick. It begins again, but for what was learned, without a usable pose."""
        pose = ego.pose_map
        values = (pose.x_m, pose.y_m, pose.yaw_rad, ego.speed_mps * ego.yaw_rate_radps)
        if not (ego.valid and all(map(math.isfinite, values)) and ego.speed_mps > self.speed_mps_min):
            return msgspec.structs.replace(state, poses=np.zeros((0, 4)))
        count = round(self.window_s / self.dt_s) + 1
        poses = np.vstack((state.poses[-count + 1 :], values))
        if len(poses) < count:
            return msgspec.structs.replace(state, poses=poses)
        slip_rad, lateral_mps2 = _slip(poses)
        lateral_mps2 *= self._dynamic(ego.speed_mps)
        keep = 1.0 - self.dt_s / self.memory_s
        if abs(slip_rad) > 2.0 * self.per_mps2_max:
            # A jump of the pose, or a slide: nothing to learn from.
            return msgspec.structs.replace(state, poses=poses)
        return RearSlipState(
            poses,
            keep * state.products + self.dt_s * slip_rad * lateral_mps2,
            keep * state.squares + self.dt_s * lateral_mps2**2,
        )

    def _dynamic(self, speed_mps: float) -> float:
        """Share of the tyres' slip in the motion; below the least speed none is used."""
        return min(max(speed_mps - self.speed_mps_min, 0.0), 1.0)


def _slip(poses: Array) -> tuple[float, float]:
    """(heading less course, lateral acceleration) of the window of poses (k, 4)."""
    first, last = poses[0], poses[-1]
    course_rad = math.atan2(last[_Y] - first[_Y], last[_X] - first[_X])
    headings = first[_YAW] + _wrapped(poses[:, _YAW] - first[_YAW])
    return float(wrap_angle(float(headings.mean()) - course_rad)), float(poses[:, _LATERAL].mean())


def _wrapped(angles: Array) -> Array:
    """(n,) the same angles within -pi to pi."""
    wrapped: Array = np.arctan2(np.sin(angles), np.cos(angles))
    return wrapped
