"""Ride quality, in the figures of Table 2 of the Snow Lion paper.

The paper does not say how the speed was differentiated. Here the true speed at 50 Hz is averaged over 0.1 s.
Its centred difference over 0.2 s, averaged over 0.5 s, is the acceleration; the centred difference of that
over 0.2 s is the jerk. All figures are of the time under way: from leaving a stop to standing at the next.
"""

from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, BoolArray

RATE_HZ = 50
_PER_SAMPLE = 5
_DT_S = _PER_SAMPLE / RATE_HZ
FAST_MPS = 9.0 / 3.6
BRAKING_MPS2 = -1.0
_BRAKING_OVER_MPS2 = -0.5
JERK_MPS3_MAX = 1.93
ACCEL_MPS2_MIN, ACCEL_MPS2_MAX = -1.83, 1.12


@dataclass(frozen=True, slots=True)
class Stretch:
    """One uninterrupted drive at 10 Hz, (n,) each: speed, acceleration, jerk."""

    speed_mps: Array
    accel_mps2: Array
    jerk_mps3: Array


@dataclass(frozen=True, slots=True)
class RideQuality:
    """Table 2. braking_km: between two events of a <= -1 m/s2, None without one.

    jerk_within_ratio: of all metres driven, those on which the jerk stayed within 1.93 m/s3
    accel_within_ratio: of all metres driven, those on which the acceleration stayed within -1.83..1.12 m/s2
    """

    distance_km: float
    driven_s: float
    speed_kmph_max: float
    speed_kmph_mean: float
    fast_ratio: float
    accel_mps2_min: float
    accel_mps2_max: float
    jerk_mps3_min: float
    jerk_mps3_max: float
    jerk_within_ratio: float
    accel_within_ratio: float
    braking_events: int
    braking_km: float | None


def stretch(speeds_mps: Array) -> Stretch | None:
    """(n,) speeds at 50 Hz of one uninterrupted drive; None if it is too short to differentiate (1.5 s)."""
    whole = len(speeds_mps) // _PER_SAMPLE * _PER_SAMPLE
    speed = np.asarray(speeds_mps[:whole], dtype=np.float64).reshape(-1, _PER_SAMPLE).mean(axis=1)
    if len(speed) < 15:
        return None
    accel = _mean(np.gradient(speed, _DT_S), 5)
    return Stretch(speed, accel, np.gradient(accel, _DT_S))


def ride_quality(stretches: list[Stretch]) -> RideQuality | None:
    """The figures of all stretches together; None without any."""
    if not stretches:
        return None
    speed = np.concatenate([one.speed_mps for one in stretches])
    accel = np.concatenate([one.accel_mps2 for one in stretches])
    jerk = np.concatenate([one.jerk_mps3 for one in stretches])
    distance_m = float(speed.sum() * _DT_S)
    events = sum(braking_events(one.accel_mps2) for one in stretches)
    return RideQuality(
        distance_km=distance_m / 1000.0,
        driven_s=len(speed) * _DT_S,
        speed_kmph_max=3.6 * float(speed.max()),
        speed_kmph_mean=3.6 * float(speed.mean()),
        fast_ratio=float((speed >= FAST_MPS).mean()),
        accel_mps2_min=float(accel.min()),
        accel_mps2_max=float(accel.max()),
        jerk_mps3_min=float(jerk.min()),
        jerk_mps3_max=float(jerk.max()),
        jerk_within_ratio=_share_of_metres(
            stretches, [np.abs(one.jerk_mps3) <= JERK_MPS3_MAX for one in stretches]
        ),
        accel_within_ratio=_share_of_metres(
            stretches,
            [(one.accel_mps2 >= ACCEL_MPS2_MIN) & (one.accel_mps2 <= ACCEL_MPS2_MAX) for one in stretches],
        ),
        braking_events=events,
        braking_km=distance_m / 1000.0 / events if events else None,
    )


def braking_events(accel_mps2: Array) -> int:
    """How often the acceleration falls to -1 m/s2; the next counts after it was above -0.5 again."""
    count, braking = 0, False
    for value in accel_mps2:
        if not braking and value <= BRAKING_MPS2:
            count, braking = count + 1, True
        elif braking and value > _BRAKING_OVER_MPS2:
            braking = False
    return count


def _share_of_metres(stretches: list[Stretch], good: list[BoolArray]) -> float:
    """Share of the metres of which every sample is good."""
    within = total = 0
    for one, samples in zip(stretches, good, strict=True):
        metre = np.floor(np.cumsum(one.speed_mps) * _DT_S).astype(np.int64)
        whole = np.ones(int(metre[-1]) + 1, dtype=np.bool_)
        np.logical_and.at(whole, metre, samples)
        within += int(whole.sum())
        total += len(whole)
    return within / total


def _mean(values: Array, width: int) -> Array:
    """Centred moving mean, with shorter windows at the ends."""
    ones = np.ones(width)
    summed: Array = np.convolve(values, ones, "same") / np.convolve(np.ones(len(values)), ones, "same")
    return summed
