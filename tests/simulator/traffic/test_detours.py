"""Ways round a rectangle: never through it, and no longer than they must be."""

import math

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely import LineString, box

from simulator.traffic.detours import crosses, next_corner

BACK, FRONT, HALF = -1.25, 4.7, 1.2
BODY = box(BACK, -HALF, FRONT, HALF)

places = st.tuples(st.floats(-6.0, 10.0), st.floats(-6.0, 6.0))


def outside(place: tuple[float, float]) -> bool:
    x, y = place
    return max(BACK - x, x - FRONT, abs(y) - HALF) > 0.01


@given(start=places, goal=places)
def test_a_straight_way_crosses_exactly_where_an_independent_library_says(
    start: tuple[float, float], goal: tuple[float, float]
) -> None:
    assume(math.dist(start, goal) > 0.1)
    inside_m = LineString([start, goal]).intersection(BODY.buffer(-1e-3, join_style="mitre")).length
    assume(inside_m == 0.0 or inside_m > 1e-3)
    assert crosses(*start, *goal, BACK, FRONT, HALF) == (inside_m > 0.0)


@given(start=places, goal=places, heading=st.floats(-3.1, 3.1))
def test_corner_by_corner_everybody_gets_round_without_walking_through(
    start: tuple[float, float], goal: tuple[float, float], heading: float
) -> None:
    assume(outside(start) and outside(goal))
    at, way_m, corners = start, 0.0, 0
    while crosses(*at, *goal, BACK, FRONT, HALF):
        to = next_corner(*at, heading, *goal, BACK, FRONT, HALF)
        assert not crosses(*at, *to, BACK, FRONT, HALF)
        way_m += math.dist(at, to)
        heading = math.atan2(to[1] - at[1], to[0] - at[0])
        at, corners = to, corners + 1
        assert corners <= 3
    way_m += math.dist(at, goal)
    hull = LineString([start, goal]).union(BODY).convex_hull.exterior.length
    if corners:
        # No longer than half way round both, and what a way that is begun may cost.
        assert way_m <= 0.5 * hull + math.dist(start, goal) + 2.0


def test_of_two_ways_that_are_as_long_the_one_that_is_begun_is_taken() -> None:
    for heading, side in ((0.5 * math.pi, 1.0), (-0.5 * math.pi, -1.0)):
        _, y = next_corner(8.0, 0.0, heading, -8.0, 0.0, BACK, FRONT, HALF)
        assert np.sign(y) == side
