"""How many shuttles with eyes of their own a machine is said to carry."""

import pytest

from campusloop.live.carried_shuttles import carried, cores, pace, scan_cpu_s
from campusloop.scenes.stacks import perceiving, profile_of


@pytest.mark.parametrize(
    ("available", "scan_s", "shuttles"),
    [(1, 0.2, 1), (2, 0.037, 1), (4, 0.027, 3), (8, 0.05, 2), (8, 0.005, 3), (1, 0.012, 2)],
)
def test_more_and_faster_cores_carry_more(available: int, scan_s: float, shuttles: int) -> None:
    assert carried(available, scan_s) == shuttles


def test_a_demo_slows_down_with_its_shuttles() -> None:
    assert pace(1, 2, 0.027) == 1.0
    assert pace(2, 2, 0.027) == pytest.approx(0.69, abs=0.03)
    assert pace(3, 2, 0.027) < pace(2, 2, 0.027)


def test_one_process_casts_the_scans_of_all_shuttles() -> None:
    assert pace(3, 64, 0.05) == pytest.approx(1.0 / (3 * 10 * 0.05 * 1.25))


def test_the_time_for_a_scan_is_measured_here() -> None:
    assert cores() >= 1
    assert 0.001 < scan_cpu_s(perceiving(profile_of("snow_lion"), own=True)) < 5.0
