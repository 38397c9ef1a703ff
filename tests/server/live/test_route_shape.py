import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import arc_lengths, curvatures
from contract.roads.network import LaneLine
from server.live.route_shape import RouteShapes, simplified


def a_line(start: tuple[float, float], end: tuple[float, float]) -> LaneLine:
    points = np.linspace(start, end, 21)
    s = arc_lengths(points)
    return LaneLine(points, s, curvatures(points), float(s[-1]))


LINES = {"a": a_line((0, 0), (20, 0)), "b": a_line((20, 0), (20, 10)), "c": a_line((20, 10), (0, 10))}


def test_the_route_begins_at_the_vehicle_and_ends_at_its_last_place() -> None:
    assert RouteShapes(LINES).ahead(("a", "b", "c"), 5.0, "a", 12.0) == ((12, 0), (20, 0), (20, 10), (15, 10))


def test_lanes_behind_the_vehicle_are_left_out() -> None:
    assert RouteShapes(LINES).ahead(("a", "b", "c"), 5.0, "b", 4.0) == ((20, 4), (20, 10), (15, 10))


def test_a_vehicle_off_its_route_gets_the_whole_of_it() -> None:
    assert RouteShapes(LINES).ahead(("a", "b"), 10.0, "elsewhere", 3.0)[0] == (0, 0)


def test_a_vehicle_that_stands_there_has_no_route() -> None:
    assert RouteShapes(LINES).ahead(("a",), 12.0, "a", 12.0) == ()


def test_lanes_of_another_map_are_left_out() -> None:
    assert RouteShapes(LINES).ahead(("x", "y"), 3.0, "a", 1.0) == ()


@given(st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=40))
def test_no_point_is_farther_from_the_simplified_line_than_allowed(points: list[tuple[float, float]]) -> None:
    line = np.array(points)
    kept = line[simplified(line, 0.5)]
    assert kept[0] == pytest.approx(line[0])
    assert kept[-1] == pytest.approx(line[-1])
    for point in line:
        gaps = [distance(point, kept[i], kept[i + 1]) for i in range(len(kept) - 1)]
        assert min(gaps) <= 0.5 + 1e-9


def distance(point: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    along = end - start
    length2 = float(along @ along)
    t = 0.0 if length2 == 0 else min(1.0, max(0.0, float((point - start) @ along) / length2))
    return float(np.linalg.norm(point - start - t * along))
