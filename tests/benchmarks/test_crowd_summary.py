"""What the summary of recorded crowds says of speed among 5 to 8 people on 100 m2."""

import pytest

from benchmarks.crowd import summary
from benchmarks.reporting.report import Row


def row(dense_s: float, dense_m: float, human_max_mps: float) -> Row:
    return {
        "stack": "snow_lion",
        "human_s": 10.0,
        "human_max_mps": human_max_mps,
        "time_s": 12.0,
        "reached": True,
        "contacts": 0,
        "clearance_m": None,
        "human_contacts": 0,
        "human_clearance_m": None,
        "dense_s": dense_s,
        "dense_m": dense_m,
        "human_dense_s": 0.5 * dense_s,
        "human_dense_m": dense_m,
    }


def test_speed_among_many_people_is_weighed_by_the_time_spent_there() -> None:
    found = summary([row(6.0, 6.0, 4.0), row(2.0, 4.0, 2.0), row(0.0, 0.0, 5.0)])
    assert found["snow_lion.dense_mps"] == pytest.approx(10.0 / 8.0)
    assert found["snow_lion.dense_speed_ratio"] == pytest.approx(10.0 / 28.0)
    assert found["snow_lion.human_dense_mps"] == pytest.approx(10.0 / 4.0)
    assert found["snow_lion.human_dense_speed_ratio"] == pytest.approx(10.0 / 14.0)


def test_recordings_without_such_moments_have_no_such_speed() -> None:
    found = summary([row(0.0, 0.0, 5.0)])
    assert found["snow_lion.dense_mps"] is None
    assert found["snow_lion.human_dense_speed_ratio"] is None
