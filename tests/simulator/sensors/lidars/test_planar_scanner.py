import math

import numpy as np
import pytest

from simulator.sensors.lidars.mounts import mount
from simulator.sensors.lidars.planar_scanner import PlanarMount, PlanarScanner
from simulator.sensors.lidars.response import LidarResponse
from simulator.sensors.scene.changes import SceneError
from tests.simulator.sensors.lidars.drives import WALL, bare_scene, moving

EXACT = LidarResponse(0.0, 40.0, 0.0, 0.0, 0.0)
HALF_TURN_AND_MORE = PlanarMount("front", mount(0.0, 0.0, 0.6, 0.0), response=EXACT)


def test_beams_cover_270_degrees_and_take_three_quarters_of_a_turn() -> None:
    scan = PlanarScanner(HALF_TURN_AND_MORE, bare_scene(WALL), np.random.default_rng(1)).scan(moving(0.0), 7)
    assert len(scan.ranges_m) == 541
    assert scan.angles_rad[[0, -1]] == pytest.approx([-0.75 * math.pi, 0.75 * math.pi])
    assert scan.offsets_ns[-1] == pytest.approx(0.75 * 20e6, rel=1e-6)


def test_moving_scanner_measures_the_wall_from_where_each_beam_is_fired() -> None:
    trajectory = moving(6.0)
    scan = PlanarScanner(HALF_TURN_AND_MORE, bare_scene(WALL), np.random.default_rng(1)).scan(trajectory, 0)
    hit = np.isfinite(scan.ranges_m)
    assert np.count_nonzero(hit) > 200
    x = 40.0 + 6.0 * 1e-9 * scan.offsets_ns + scan.ranges_m * np.cos(scan.angles_rad)
    assert np.abs(x[hit] - 52.0).max() < 0.002
    assert not hit[[0, -1]].any()


def test_full_turn_has_no_beam_twice() -> None:
    all_round = PlanarMount(
        "top", mount(0.0, 0.0, 0.6, 0.0), field_rad=2.0 * math.pi, step_rad=math.pi / 180.0
    )
    scan = PlanarScanner(all_round, bare_scene(WALL), np.random.default_rng(1)).scan(moving(0.0), 0)
    assert len(scan.angles_rad) == 360


def test_field_of_view_of_more_than_a_turn_is_refused() -> None:
    with pytest.raises(SceneError):
        PlanarMount("top", np.eye(4), field_rad=7.0)
