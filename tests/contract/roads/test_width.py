"""How much room a body has beside its line."""

import numpy as np
import pytest

from contract.geometry import Array
from contract.roads.model import Building
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine, find_route, route_line
from contract.roads.width import drivable_width
from tests.contract.roads.ring_map import ring_map

NETWORK = RoadNetwork(ring_map())


def a_line() -> ReferenceLine:
    """Along the first side, eastwards on y = 0, from x = 10 to x = 90; the lane is 4 m wide."""
    route = find_route(NETWORK, "side-0", 10.0, "side-0", 90.0)
    assert route is not None
    return route_line(NETWORK, route)


LINE = a_line()


def room(*buildings: tuple[tuple[float, float], ...]) -> tuple[Array, Array]:
    return drivable_width(NETWORK, LINE, [Building(outline, 6.0) for outline in buildings])


def at(x_m: float, values: Array) -> float:
    return float(values[int(np.argmin(np.abs(LINE.points[:, 0] - x_m)))])


def box(x0: float, y0: float, x1: float, y1: float) -> tuple[tuple[float, float], ...]:
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def test_a_one_way_road_gives_half_its_width_on_both_sides() -> None:
    left_m, right_m = room()
    assert np.allclose(left_m, 2.0)
    assert np.allclose(right_m, 2.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_building_beside_the_road_takes_room_on_its_side_and_where_it_stands(sign: float) -> None:
    near, far = sorted((1.2 * sign, 9.0 * sign))
    left_m, right_m = room(box(40.0, near, 60.0, far))
    narrow, free = (left_m, right_m) if sign > 0.0 else (right_m, left_m)
    assert at(50.0, narrow) == pytest.approx(1.2)
    assert at(40.0, narrow) == pytest.approx(1.2)
    assert at(39.0, narrow) == pytest.approx(2.0)
    assert at(62.0, narrow) == pytest.approx(2.0)
    assert np.allclose(free, 2.0)


def test_a_building_across_the_line_leaves_no_room_there() -> None:
    left_m, right_m = room(box(50.0, -3.0, 52.0, 3.0))
    assert (at(50.0, left_m), at(50.0, right_m)) == (0.0, 0.0)
    assert (at(46.0, left_m), at(46.0, right_m)) == (2.0, 2.0)


def test_a_wall_farther_than_the_lane_is_wide_takes_nothing() -> None:
    left_m, right_m = room(box(40.0, 2.5, 60.0, 9.0), box(40.0, -90.0, 60.0, -80.0))
    assert np.allclose(left_m, 2.0)
    assert np.allclose(right_m, 2.0)


def test_every_building_takes_what_it_stands_on_whatever_the_order() -> None:
    houses = [box(20.0, 1.5, 25.0, 9.0), box(40.0, 90.0, 60.0, 99.0), box(70.0, -9.0, 75.0, -1.0)]
    for order in ((0, 1, 2), (2, 1, 0), (1, 0, 2)):
        left_m, right_m = room(*(houses[number] for number in order))
        assert (at(22.0, left_m), at(22.0, right_m)) == (pytest.approx(1.5), 2.0)
        assert (at(72.0, left_m), at(72.0, right_m)) == (2.0, pytest.approx(1.0))
        assert (at(50.0, left_m), at(50.0, right_m)) == (2.0, 2.0)


def test_a_slanting_wall_takes_as_much_as_it_comes_near() -> None:
    left_m, _ = room(((40.0, 1.0), (60.0, 3.0), (50.0, 9.0)))
    for x_m in (42.0, 45.0, 48.0):
        nearest_m = 1.0 + (x_m - 0.6 - 40.0) / 10.0
        assert at(x_m, left_m) == pytest.approx(min(2.0, nearest_m), abs=0.01)
