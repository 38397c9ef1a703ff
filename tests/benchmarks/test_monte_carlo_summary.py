"""What the summary of random drives says of speed: sparse and dense crowds, each beside an empty road."""

import pytest

from benchmarks.monte_carlo.__main__ import summary
from benchmarks.reporting.report import Row


def row(per_100m2: float, mean_mps: float, free_mps: float | None) -> Row:
    return {
        "stack": "snow_lion",
        "people_per_100m2": per_100m2,
        "people_met_per_100m2": per_100m2 + 1.0,
        "mean_mps": mean_mps,
        "free_mps": free_mps,
        "contacts": 0,
        "other_contacts": 0,
        "clearance_m": None,
        "stalls": 0,
        "reached": True,
        "people_removed": 0,
    }


def test_sparse_and_dense_crowds_are_compared_apart() -> None:
    found = summary([row(0.5, 2.4, 3.0), row(3.0, 1.5, None), row(6.0, 0.6, 3.0), row(7.9, 0.9, 3.0)])
    assert found["snow_lion.mean_speed_ratio"] == pytest.approx(0.8)
    assert found["snow_lion.dense_runs"] == 2
    assert found["snow_lion.dense_speed_ratio"] == pytest.approx(0.25)
    assert found["snow_lion.dense_people_met_per_100m2"] == pytest.approx(7.95)


def test_without_dense_crowds_there_is_no_ratio() -> None:
    found = summary([row(0.5, 2.4, 3.0)])
    assert found["snow_lion.dense_runs"] == 0
    assert found["snow_lion.dense_speed_ratio"] is None
