"""What the vehicle does beyond its identified response, learned from its speed reports.

A Kalman filter over speed, disturbance and the strength of each pedal. A load makes both pedals weaker, a
slope adds the same to each, and no two drives or brakes are alike. A disturbance alone is right only for the
pedal it was learned with. With the next one the vehicle leaps or overruns until it is learned anew.
"""

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array

# Entries of the mean; those of the covariance begin with the speed.
DISTURBANCE, DRIVE_GAIN, BRAKE_GAIN = range(3)
SIZE = 4


class PedalFilter(msgspec.Struct, frozen=True):
    """Measurement noise, process noise and bounds.

    report_mps            noise of a speed report, errors of the dead times included
    speed_mps, disturbance_mps2  process noise per square root of a second
    gain                  the same of a pedal's strength, for each m/s2 that the pedal gives
    gain_std              of the profile's pedals, before anything is learned
    disturbance_std_mps2  the same of the disturbance, after by-wire began
    *_max, *_min          what is beyond is a fault of the vehicle, or another vehicle's profile
    """

    report_mps: float = 0.02
    speed_mps: float = 0.02
    disturbance_mps2: float = 0.03
    gain: float = 0.02
    gain_std: float = 0.2
    disturbance_std_mps2: float = 0.1
    disturbance_mps2_max: float = 1.5
    gain_min: float = 0.5
    gain_max: float = 2.0

    def row(self) -> Array:
        """(9,) the parameters for the kernels, in the order of the fields."""
        return np.array(msgspec.structs.astuple(self), dtype=np.float64)


class PedalFilterState(msgspec.Struct, frozen=True):
    """What is known of the pedals.

    mean (3,)          acceleration that no pedal explains (m/s2); how strong throttle and brake are, 1 as in
                       the profile
    covariance (4, 4)  of the speed and the mean
    """

    mean: Array
    covariance: Array

    @property
    def disturbance_mps2(self) -> float:
        return float(self.mean[DISTURBANCE])

    @property
    def drive_gain(self) -> float:
        return float(self.mean[DRIVE_GAIN])

    @property
    def brake_gain(self) -> float:
        return float(self.mean[BRAKE_GAIN])


def initial_pedal_state(filter: PedalFilter) -> PedalFilterState:
    """The state of a vehicle of which the profile is all that is known."""
    variances = (
        np.array((filter.report_mps, filter.disturbance_std_mps2, filter.gain_std, filter.gain_std)) ** 2
    )
    return PedalFilterState(np.array((0.0, 1.0, 1.0)), np.diag(variances))


def without_disturbance(state: PedalFilterState, filter: PedalFilter) -> PedalFilterState:
    """The state with the disturbance to be learned afresh; the pedals' strength is the vehicle's own."""
    mean, P = state.mean.copy(), state.covariance.copy()
    mean[DISTURBANCE] = 0.0
    P[:2, :] = P[:, :2] = 0.0
    P[0, 0], P[1, 1] = filter.report_mps**2, filter.disturbance_std_mps2**2
    return PedalFilterState(mean, P)


def with_known_speed(state: PedalFilterState) -> PedalFilterState:
    """The state of a vehicle whose speed was set: at a stand, or while another brakes it."""
    P = state.covariance.copy()
    P[0, :] = P[:, 0] = 0.0
    return PedalFilterState(state.mean, P)


@njit(cache=True)
def predict_speed(P: Array, drive: float, brake: float, dt: float, n: Array) -> None:
    """Propagates P (4, 4) in place over dt; drive, brake: what each pedal gives a nominal vehicle (m/s2)."""
    F = np.eye(SIZE)
    F[0, 1], F[0, 2], F[0, 3] = dt, drive * dt, -brake * dt
    P[:, :] = F @ P @ F.T
    P[0, 0] += n[1] ** 2 * dt
    P[1, 1] += n[2] ** 2 * dt
    P[2, 2] += (n[3] * drive) ** 2 * dt
    P[3, 3] += (n[3] * brake) ** 2 * dt


@njit(cache=True)
def update_speed(mean: Array, P: Array, innovation: float, n: Array) -> float:
    """Corrects mean (3,) and P (4, 4) in place by a speed report; returns the speed's correction (m/s)."""
    K = P[:, 0] / (P[0, 0] + n[0] ** 2)
    P -= np.outer(K, P[0].copy())
    for i in range(3):
        mean[i] += K[i + 1] * innovation
    mean[0] = min(max(mean[0], -n[6]), n[6])
    for i in range(1, 3):
        mean[i] = min(max(mean[i], n[7]), n[8])
    return float(K[0] * innovation)
