"""Which sections closures mean, at which time, and the way off closed road."""

from datetime import UTC, datetime, timedelta

import pytest

from contract.roads.network import RoadNetwork
from server.domain.roads.closures import Closure, ClosureState
from server.travel.closed_roads import sections_closed, sections_closed_within, way_out
from tests.server.usecases.shipped_maps import shipped_map

NETWORK = RoadNetwork(shipped_map("snow-lion"))
NOON = datetime(2026, 11, 23, 12, 0, tzinfo=UTC)
HOUR = timedelta(hours=1)
LANE = "east-4"
ON_LANE = {section.section_id for section in NETWORK.sections_of(LANE)}


def a_closure(
    lanes: tuple[str, ...] = (LANE,),
    sections: tuple[str, ...] = (),
    starts_at: datetime = NOON,
    ends_at: datetime | None = NOON + HOUR,
    state: ClosureState = ClosureState.SCHEDULED,
) -> Closure:
    return Closure("snow-lion", "c", lanes, sections, "", starts_at, ends_at, "ann", NOON - HOUR, state)


@pytest.mark.parametrize(
    ("begins", "ends", "closed"),
    [
        (NOON - 2 * HOUR, NOON - timedelta(seconds=1), False),
        (NOON - HOUR, NOON, True),
        (NOON - HOUR, NOON + timedelta(minutes=1), True),
        (NOON + timedelta(minutes=10), NOON + timedelta(minutes=20), True),
        (NOON + timedelta(minutes=59), NOON + 2 * HOUR, True),
        (NOON + HOUR, NOON + 2 * HOUR, False),
        (NOON - HOUR, NOON + 2 * HOUR, True),
    ],
)
def test_a_road_is_closed_to_a_ride_when_the_closure_holds_at_any_moment_of_it(
    begins: datetime, ends: datetime, closed: bool
) -> None:
    found = sections_closed_within((a_closure(),), NETWORK, begins, ends)
    assert found == (ON_LANE if closed else frozenset())


def test_a_closure_without_an_end_holds_for_ever_and_one_that_is_over_never() -> None:
    late = NOON + 1000 * HOUR
    assert sections_closed_within((a_closure(ends_at=None),), NETWORK, late, late) == ON_LANE
    over = a_closure(ends_at=None, state=ClosureState.OVER)
    assert sections_closed_within((over,), NETWORK, NOON, late) == frozenset()


def test_only_closures_in_force_close_road_now() -> None:
    one = min(ON_LANE)
    in_force = a_closure((), (one,), state=ClosureState.IN_FORCE)
    assert sections_closed((a_closure(), in_force), NETWORK) == {one}


def test_lanes_and_sections_of_another_map_are_left_out() -> None:
    foreign = a_closure(("elsewhere", LANE), ("elsewhere/0",), state=ClosureState.IN_FORCE)
    assert sections_closed((foreign,), NETWORK) == ON_LANE


def test_a_vehicle_on_closed_road_may_drive_on_to_its_end_and_one_beside_it_may_not_enter() -> None:
    along = [section.section_id for section in NETWORK.sections_of(LANE)]
    after = [NETWORK.sections_of(lane)[0].section_id for lane in NETWORK.successors(LANE)]
    closed = {*along, *after}
    assert way_out(NETWORK, along[0], closed) == closed
    assert way_out(NETWORK, along[-1], closed) == {along[-1], *after}
    assert way_out(NETWORK, along[0], closed - set(along[:1])) == frozenset()
