"""Points for people who look: few, spread, where they were measured, and the same each time."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from vehicle_agent.config import Profile
from vehicle_agent.perception.thinned_scans import ScanThinning, ThinnedScans
from vehicle_agent.stacks.rooms import scan_thinning

COORDINATES = st.floats(-60.0, 60.0, width=32) | st.sampled_from([np.nan, np.inf, -np.inf])
SCANS = st.integers(0, 300).flatmap(lambda n: arrays(np.float32, (n, 3), elements=COORDINATES))


def points_of(scan_points: np.ndarray, thinning: ScanThinning) -> np.ndarray:
    found = thinning.thinned(scan_points, 7)
    assert found.stamp_ns == 7
    return 0.01 * np.frombuffer(found.points_cm, "<i2").reshape(-1, 3)


@settings(max_examples=60)
@given(SCANS, st.integers(1, 40))
def test_what_is_shown_was_measured_and_is_no_more_than_may_be(points: np.ndarray, count: int) -> None:
    thinning = ScanThinning(points_max=count)
    shown = points_of(points, thinning)
    assert len(shown) <= count
    measured = points[np.isfinite(points).all(axis=1)]
    for one in shown:
        assert np.abs(measured - one).max(axis=1).min() <= 0.0051
        assert thinning.above_m - 0.01 <= one[2] <= thinning.below_m + 0.01
        assert np.hypot(one[0], one[1]) <= thinning.reach_m + 0.01
    assert np.array_equal(shown, points_of(points, thinning))


def test_a_wall_of_many_points_keeps_its_ends_and_a_lone_thing_its_point() -> None:
    wall = np.column_stack((np.linspace(-20.0, 20.0, 50_000), np.full(50_000, 5.0), np.full(50_000, 1.0)))
    road = np.zeros((50_000, 3))
    person = np.tile([10.0, -4.0, 1.2], (20, 1))
    shown = points_of(np.vstack((wall, person, road)).astype(np.float32), ScanThinning())
    on_wall = shown[shown[:, 1] == 5.0]
    assert len(shown) == len(on_wall) + 1
    assert on_wall[:, 0].min() < -19.5
    assert on_wall[:, 0].max() > 19.5
    assert np.diff(np.sort(on_wall[:, 0])).max() < 0.6


def test_the_own_roof_is_not_shown_and_a_person_before_the_bumper_is() -> None:
    thinning = scan_thinning(Profile())
    body = Profile().body
    roof = [[x, 0.0, body.height_m] for x in np.linspace(-body.rear_overhang_m, body.front_overhang_m, 20)]
    person = [body.front_overhang_m + 0.6, 0.0, 1.0]
    assert points_of(np.array([*roof, person], np.float32), thinning).shape == (1, 3)


def test_a_scan_a_second_is_shown_also_after_the_clock_went_back() -> None:
    scans = ThinnedScans()
    taken = [k for k in range(25) if scans.takes(100_000_000 * k)]
    assert taken == [0, 10, 20]
    assert scans.takes(5)
