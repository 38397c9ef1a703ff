"""The lanes that an order leads over."""

import pytest

from contract.wire.messages import Visit
from server.domain.orders.orders import lanes_of


def visit(*route: str) -> Visit:
    return Visit("v", "stop", "gate", route[-1] if route else "a", 0.0, route)


@pytest.mark.parametrize(
    ("routes", "lanes"),
    [
        ((), ()),
        ((("a",),), ("a",)),
        ((("a", "b"), ("b", "c")), ("a", "b", "c")),
        ((("a", "b", "c"), ("c",), ("c", "d")), ("a", "b", "c", "d")),
        ((("a", "b"), (), ("b", "a", "b")), ("a", "b", "a", "b")),
    ],
)
def test_a_lane_on_which_one_visit_ends_and_the_next_way_begins_is_driven_once(
    routes: tuple[tuple[str, ...], ...], lanes: tuple[str, ...]
) -> None:
    assert lanes_of([visit(*route) for route in routes]) == lanes
