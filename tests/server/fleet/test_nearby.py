from hypothesis import given
from hypothesis import strategies as st

from server.fleet.nearby import Nearby

COORDINATE = st.floats(-500.0, 500.0)
MOVES = st.lists(st.tuples(st.sampled_from("abcdef"), COORDINATE, COORDINATE), max_size=40)


@given(MOVES)
def test_the_vehicles_near_are_those_within_the_radius_and_no_others(
    moves: list[tuple[str, float, float]],
) -> None:
    nearby = Nearby(60.0)
    places: dict[str, tuple[float, float]] = {}
    for vehicle_id, x_m, y_m in moves:
        found = nearby.move(vehicle_id, x_m, y_m)
        places[vehicle_id] = (x_m, y_m)
        assert found == sorted(
            other
            for other, (ox_m, oy_m) in places.items()
            if other != vehicle_id and ((ox_m - x_m) ** 2 + (oy_m - y_m) ** 2) ** 0.5 <= 60.0
        )


def test_a_vehicle_exactly_as_far_away_as_the_radius_is_near() -> None:
    nearby = Nearby(5.0)
    nearby.move("a", 0.0, 0.0)
    assert nearby.move("b", 3.0, 4.0) == ["a"]
    assert nearby.move("b", 3.0, 4.001) == []


def test_a_vehicle_that_was_removed_is_near_nobody() -> None:
    nearby = Nearby(60.0)
    nearby.move("a", 0.0, 0.0)
    nearby.remove("a")
    nearby.remove("a")
    assert nearby.move("b", 1.0, 0.0) == []
