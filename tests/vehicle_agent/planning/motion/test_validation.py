"""Requests that cannot be planned for are refused by the name of what is wrong with them."""

import math
from typing import Any

import msgspec
import numpy as np
import pytest

from tests.vehicle_agent.planning.motion.scenes import a_corridor, a_request
from vehicle_agent.planning.motion.request import MotionRequestError
from vehicle_agent.planning.motion.validation import check_request

ROAD = a_corridor()
N = len(ROAD.s_m)
STATIONS = ("reference_l_m", "lower_l_m", "upper_l_m", "speed_mps_max")


def with_corridor(**changes: Any) -> Any:
    return msgspec.structs.replace(a_request(), corridor=msgspec.structs.replace(ROAD, **changes))


def spoiled(values: np.ndarray, at: Any, value: float) -> np.ndarray:
    out = values.copy()
    out[at] = value
    return out


def test_an_ordinary_request_passes_also_without_bounds_and_with_one_station() -> None:
    check_request(a_request())
    check_request(a_request(end_s_m=math.inf, upper_l_m=np.full(N, math.inf)))
    one = msgspec.structs.replace(ROAD, s_m=ROAD.s_m[:1], points_map=ROAD.points_map[:1])
    check_request(a_request(one, **{name: np.ones(1) for name in STATIONS}))


@pytest.mark.parametrize("name", STATIONS)
def test_values_by_station_have_the_corridors_length_and_are_numbers(name: str) -> None:
    for broken, text in ((np.zeros(N - 1), "shape"), (spoiled(np.zeros(N), 7, math.nan), "NaN")):
        with pytest.raises(MotionRequestError, match=f"{name} has .*{text}"):
            check_request(a_request(**{name: broken}))


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"points_map": ROAD.points_map[:-1]}, "points_map"),
        ({"points_map": spoiled(ROAD.points_map, (3, 1), math.inf)}, "points_map"),
        ({"s_m": spoiled(ROAD.s_m, 3, ROAD.s_m[2])}, "must rise"),
        ({"s_m": spoiled(ROAD.s_m, -1, math.nan)}, "must rise"),
        ({"s_m": spoiled(ROAD.s_m, 3, ROAD.s_m[3] + 0.02)}, "even steps"),
    ],
)
def test_the_corridor_is_a_line_at_even_steps(changes: dict[str, Any], text: str) -> None:
    with pytest.raises(MotionRequestError, match=text):
        check_request(with_corridor(**changes))


def test_steps_that_differ_by_less_than_two_percent_are_even() -> None:
    check_request(with_corridor(s_m=spoiled(ROAD.s_m, 3, ROAD.s_m[3] + 0.004)))


@pytest.mark.parametrize(
    "start",
    [
        {"pose": (math.nan, 0.0, 0.0)},
        {"pose": (0.0, math.inf, 0.0)},
        {"pose": (0.0, 0.0, math.nan)},
        {"speed_mps": math.inf},
        {"accel_mps2": math.nan},
        {"curvature_1pm": math.nan},
    ],
)
def test_the_start_is_finite(start: dict[str, Any]) -> None:
    with pytest.raises(MotionRequestError, match="start"):
        check_request(a_request(**start))


@pytest.mark.parametrize("discs", [np.zeros(3), np.zeros((2, 2)), np.array([[0.0, 0.0, math.nan]])])
def test_obstacles_are_finite_discs(discs: np.ndarray) -> None:
    with pytest.raises(MotionRequestError, match="static_discs"):
        check_request(a_request(static_discs=discs))


def test_the_stop_is_a_number() -> None:
    with pytest.raises(MotionRequestError, match="end_s_m"):
        check_request(a_request(end_s_m=math.nan))
