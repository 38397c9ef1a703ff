"""Table 2's figures on drives whose figures are known."""

import numpy as np
import pytest

from simulator.scoring.ride_quality import braking_events, ride_quality, stretch

DT_S = 0.02


def trapezium(top_mps: float, accel_mps2: float, cruise_s: float) -> np.ndarray:
    up = np.arange(0.0, top_mps, accel_mps2 * DT_S)
    return np.concatenate(
        (np.zeros(25), up, np.full(round(cruise_s / DT_S), top_mps), up[::-1], np.zeros(25))
    )


def test_speeds_and_accelerations_of_a_known_drive() -> None:
    speeds = trapezium(3.0, 0.8, 60.0)
    quality = ride_quality([found] if (found := stretch(speeds)) is not None else [])
    assert quality is not None
    assert quality.distance_km == pytest.approx(speeds.sum() * DT_S / 1000.0, rel=1e-3)
    assert quality.speed_kmph_max == pytest.approx(10.8)
    assert quality.fast_ratio == pytest.approx((speeds >= 2.5).mean(), abs=0.01)
    assert (quality.accel_mps2_min, quality.accel_mps2_max) == pytest.approx((-0.8, 0.8), abs=0.01)
    assert quality.braking_events == 0
    assert quality.braking_km is None
    assert quality.jerk_within_ratio == 1.0
    assert quality.accel_within_ratio == 1.0


def test_a_hard_braking_is_an_event_and_its_metres_are_rough() -> None:
    soft, hard = trapezium(3.0, 0.8, 60.0), trapezium(3.0, 3.0, 60.0)
    found = [one for speeds in (soft, hard) if (one := stretch(speeds)) is not None]
    quality = ride_quality(found)
    assert quality is not None
    assert quality.braking_events == 1
    assert quality.braking_km == pytest.approx(quality.distance_km)
    assert 0.95 < quality.jerk_within_ratio < 1.0
    # 3 m/s2 up to 3 m/s and down again take 1.5 m each; whole metres count, and the mean blurs their ends.
    rough_m = (1.0 - quality.accel_within_ratio) * 1000.0 * quality.distance_km
    assert 2.0 <= round(rough_m) <= 5.0
    assert quality.jerk_mps3_min < -1.93


def test_a_braking_that_wavers_is_one_event() -> None:
    assert braking_events(np.array([0.0, -1.1, -0.9, -1.2, -0.6, -1.3, 0.0])) == 1
    assert braking_events(np.array([0.0, -1.1, -0.4, -1.2, 0.0, -1.0])) == 3


def test_nothing_driven_has_no_quality() -> None:
    assert stretch(np.zeros(20)) is None
    assert ride_quality([]) is None
