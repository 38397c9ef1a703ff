"""How many shuttles with eyes of their own a machine is said to carry."""

import pytest

from campusloop.live.carried_shuttles import carried, cores, scan_cpu_s
from campusloop.scenes.stacks import perceiving, profile_of


@pytest.mark.parametrize(
    ("available", "scan_s", "shuttles"), [(1, 0.2, 1), (2, 0.037, 1), (4, 0.037, 3), (8, 0.012, 22)]
)
def test_more_and_faster_cores_carry_more(available: int, scan_s: float, shuttles: int) -> None:
    assert carried(available, scan_s) == shuttles


def test_the_time_for_a_scan_is_measured_here() -> None:
    assert cores() >= 1
    assert 0.001 < scan_cpu_s(perceiving(profile_of("snow_lion"), own=True)) < 5.0
