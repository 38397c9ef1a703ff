"""Hidden ground that a camera has seen to be free: how far, for how long, and what it is worth."""

import numpy as np
import pytest

from vehicle_agent.planning.behaviour.cleared_ground import PICTURE_AGE_NS_MAX, with_cleared_ground
from vehicle_agent.planning.behaviour.occlusion import (
    H_CLEARED,
    OcclusionRules,
    PathStations,
    occlusion_speeds,
)
from vehicle_agent.signals import WatchedArea

N, HALF_M, REACH_M, RUN_MPS = 80, 0.8, 3.0, 2.2
S = 1_000_000_000
PATH = PathStations(np.column_stack((0.5 * np.arange(N), np.zeros(N))), np.zeros(N), np.zeros(N), 0, N)
RULES = OcclusionRules(3.5, 0.3, HALF_M, RUN_MPS, 0.6, 5.0, 1.0, walk_mps=1.6)


def hidden(beside_m: float = 0.5) -> np.ndarray:
    """A corner 0.5 m beside the body at station 40."""
    rows = np.full((N, 4), np.inf)
    rows[:, H_CLEARED] = 0.0
    rows[40] = (beside_m, 1.0, HALF_M + beside_m, 0.0)
    return rows


def area(reach_m: float, clear_ns: int = S) -> WatchedArea:
    """Free to reach_m on both sides of the line, about station 40."""
    outline = ((10.0, -reach_m), (30.0, -reach_m), (30.0, reach_m), (10.0, reach_m))
    return WatchedArea("a", (), False, clear_ns, outline)


def cleared_m(watched: WatchedArea, age_s: float = 0.0) -> float:
    stamp_ns = watched.clear_ns + round(age_s * S)
    return float(
        with_cleared_ground(hidden(), PATH, (watched,), stamp_ns, HALF_M, REACH_M, 0.25, RUN_MPS)[
            40, H_CLEARED
        ]
    )


def test_ground_is_cleared_as_far_as_the_camera_looks_and_beyond_reach_it_does_not_matter() -> None:
    assert cleared_m(area(2.9)) == pytest.approx(2.0, abs=0.26)
    assert cleared_m(area(6.0)) == np.inf


def test_what_a_runner_has_come_since_the_picture_is_not_cleared() -> None:
    assert cleared_m(area(2.9), 0.5) == pytest.approx(cleared_m(area(2.9)) - 1.1)
    assert cleared_m(area(2.9), 1.2) == 0.0


def test_an_old_picture_and_a_camera_that_is_not_believed_clear_nothing() -> None:
    assert cleared_m(area(6.0), PICTURE_AGE_NS_MAX * 1e-9 + 0.01) == 0.0
    outline = area(6.0).outline
    untold = WatchedArea("a", (), False, 0, outline)
    assert (
        with_cleared_ground(hidden(), PATH, (untold,), S, HALF_M, REACH_M, 0.25, RUN_MPS)[40, H_CLEARED]
        == 0.0
    )


def test_a_camera_over_one_side_only_clears_nothing() -> None:
    outline = ((10.0, -1.0), (30.0, -1.0), (30.0, 6.0), (10.0, 6.0))
    one_sided = WatchedArea("a", (), False, S, outline)
    assert (
        with_cleared_ground(hidden(), PATH, (one_sided,), S, HALF_M, REACH_M, 0.25, RUN_MPS)[40, H_CLEARED]
        <= 0.0
    )


def speeds(cleared: float) -> np.ndarray:
    rows = hidden()
    rows[40, H_CLEARED] = cleared
    return np.asarray(occlusion_speeds(rows, 0.5, 4.0, RULES))


def test_cleared_ground_is_worth_speed_but_somebody_who_walks_is_always_reckoned_with() -> None:
    without, partly, wholly = speeds(0.0), speeds(1.0), speeds(np.inf)
    assert (partly >= without).all()
    assert (wholly >= partly).all()
    assert wholly.min() >= without.min()
    assert wholly.sum() > without.sum()
    walkers = RULES._replace(run_mps=RULES.walk_mps)
    walking = np.asarray(occlusion_speeds(hidden(), 0.5, 4.0, walkers))
    assert (wholly <= walking + 1e-9).all()
