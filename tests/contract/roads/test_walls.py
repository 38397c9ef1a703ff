"""Buildings as walls."""

import pytest

from contract.roads.model import Building
from contract.roads.walls import edges_near, wall_edges

TRIANGLE = Building(((0.0, 0.0), (10.0, 0.0), (10.0, 4.0)), 6.0)


def test_every_side_of_a_building_is_a_wall_the_last_one_closes_it() -> None:
    assert wall_edges((TRIANGLE,)).tolist() == [
        [0.0, 0.0, 10.0, 0.0],
        [10.0, 0.0, 10.0, 4.0],
        [10.0, 4.0, 0.0, 0.0],
    ]
    assert len(wall_edges((TRIANGLE, TRIANGLE))) == 6
    assert wall_edges(()).shape == (0, 4)


@pytest.mark.parametrize(
    ("place", "near"),
    [
        ((12.9, 2.0), 3),
        ((13.1, 2.0), 0),
        ((-2.9, 0.0), 2),
        ((-3.1, 0.0), 0),
        ((5.0, -2.9), 2),
        ((5.0, -3.1), 0),
        ((5.0, 6.9), 1),
        ((5.0, 7.1), 0),
        ((9.0, 2.0), 3),
    ],
)
def test_a_wall_is_near_when_its_bounds_come_within_the_distance(
    place: tuple[float, float], near: int
) -> None:
    assert len(edges_near(wall_edges((TRIANGLE,)), *place, 3.0)) == near
