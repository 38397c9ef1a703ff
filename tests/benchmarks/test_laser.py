"""The benchmarks of mapping and localization with a laser: what their figures mean."""

import os
from pathlib import Path

import numpy as np
import pytest

from benchmarks.amcl import Moments, episode, figures
from benchmarks.slam2d import measured
from tests.workshop.simulated_drive import drive
from vehicle_agent.localization.laser.pose_arrays import between
from vehicle_agent.localization.monte_carlo.localization import MonteCarloLocalization
from workshop.carmen.laser_logs import read_laser_log
from workshop.laser_mapping.mapping import MappingParams, NoProgress, map_log
from workshop.laser_mapping.relations import Relations

ROOT = Path(__file__).resolve().parents[2]
SHARED = Path(os.environ.get("CAMPUSLOOP_SHARED", ROOT.parent / "shared"))


def moments(error_m: list[float], lost: list[float]) -> Moments:
    count = len(error_m)
    return Moments(
        0.2 * np.arange(count),
        np.array(error_m),
        np.zeros(count),
        np.array(lost),
        np.full(count, 3.0),
        np.full(count, 500.0),
        np.full(count, 1e-3),
        np.full(count, 2e-3),
        0.1,
    )


def test_found_is_when_it_is_right_and_says_so() -> None:
    row = figures([moments([4.0, 0.1, 0.1, 3.0], [0.1, 0.9, 0.2, 0.2])])
    assert row["found_pct"] == 100.0
    assert row["found_s"] == pytest.approx(0.4)
    assert row["rmse_m"] == pytest.approx(np.sqrt((0.1**2 + 3.0**2) / 2))
    assert row["wrong_pct"] == 50.0
    assert (row["p95_ms"], row["p95_cpu_ms"]) == (pytest.approx(2.0), pytest.approx(1.0))


def test_what_was_never_found_has_no_error() -> None:
    row = figures([moments([4.0, 4.0], [0.9, 0.9]), moments([0.1] * 150, [0.9] * 149 + [0.1])])
    assert row["found_pct"] == 0.0
    assert row["found_s"] == pytest.approx(29.8)
    assert figures([moments([4.0], [0.9])])["rmse_m"] is None


def test_a_simulated_log_is_mapped_and_localized_within_the_floors() -> None:
    driven = drive(rounds=1.2, seed=9)
    laser_map = map_log(driven.log, MappingParams(), NoProgress())
    pairs = np.array([(i, j) for i in range(0, 300, 10) for j in (i + 5, i + 15)])
    relations = Relations(
        driven.log.stamps_s[pairs], between(driven.truth[pairs[:, 0]], driven.truth[pairs[:, 1]])
    )
    row = measured(driven.log, laser_map, relations)
    assert row["relations"] == len(pairs)
    assert row["mean_m"] < 0.03
    assert row["mean_deg"] < 0.5
    localization = MonteCarloLocalization.in_map(laser_map.occupancy)
    row = figures([episode(localization, driven.log, laser_map.poses, 40, 10.0, 0.3, 1)])
    assert row["found_pct"] == 100.0
    assert row["rmse_m"] < 0.1


@pytest.mark.long
@pytest.mark.parametrize("name", ["fr079.clf.bz2", "mit-csail.clf.bz2"])
def test_a_real_log_gives_a_map_whose_passes_agree(name: str) -> None:
    path = SHARED / "data" / "slam2d" / name
    if not path.exists():
        pytest.skip(f"no log {path}; set CAMPUSLOOP_SHARED")
    laser_map = map_log(read_laser_log(path), MappingParams(), NoProgress())
    assert laser_map.residuals.loops_closed > 50
    assert laser_map.residuals.pass_median_m < 0.01
    assert laser_map.residuals.pass_p95_m < 0.04
