"""What is offered instead of a refused ride: rides that would be accepted, and that are in time on foot."""

from dataclasses import replace

import numpy as np
import pytest

from server.dispatch.alternatives import OFFERED_MAX, Alternative, alternatives
from server.dispatch.problem import Problem, Request, VehicleState, Walk
from server.dispatch.schedule.schedule import Schedule

# Four places in a row, 100 s of driving apart; one shuttle stands at the first.
TIMES_S = 100.0 * np.abs(np.subtract.outer(np.arange(4.0), np.arange(4.0)))
DWELL_S = 10.0


def a_board(seats: int = 4, ready_s: float = 0.0, shuttles: int = 1) -> Schedule:
    fleet = tuple(VehicleState(f"v{k}", TIMES_S[0], ready_s, seats, 1) for k in range(shuttles))
    return Schedule(Problem(fleet, {}, TIMES_S, dwell_s=DWELL_S), spare=8)


def a_wish(**changes: object) -> Request:
    """From the second place to the last one, at once."""
    wish = Request("r", 1, 3, 1, 0, 0.0, 50.0, 2000.0)
    return replace(wish, **changes)  # type: ignore[arg-type]


def offered(
    schedule: Schedule,
    wish: Request,
    up: tuple[Walk, ...] = (),
    down: tuple[Walk, ...] = (),
    later_s: float = 0.0,
) -> list[Alternative]:
    return alternatives(schedule, wish, up, down, later_s)


def test_a_later_ride_is_offered_when_nobody_can_come_in_time() -> None:
    (later,) = offered(a_board(), a_wish(), later_s=600.0)
    assert (later.kind, later.pickup, later.dropoff, later.walk_s) == ("later", 1, 3, 0.0)
    assert later.pickup_s == (100.0,)
    assert later.arrival_s == (100.0 + DWELL_S + 200.0,)
    assert later.penalty_s == 100.0


def test_a_ride_that_could_only_be_later_than_allowed_is_not_offered() -> None:
    assert offered(a_board(), a_wish(), later_s=49.0) == []


def test_who_walks_to_another_stop_is_picked_up_after_the_walk() -> None:
    schedule = a_board()
    (near,) = offered(schedule, a_wish(), up=(Walk(0, 70.0),))
    assert (near.kind, near.pickup, near.walk_s) == ("other_stops", 0, 70.0)
    assert near.pickup_s == (70.0,)
    assert near.penalty_s == pytest.approx(1.5 * 70.0)


@pytest.mark.parametrize(("walk_s", "in_time"), [(80.0, True), (95.0, False)])
def test_who_walks_on_from_another_stop_is_still_in_time_on_foot(walk_s: float, in_time: bool) -> None:
    """The shuttle comes to the third place at 210 s; who must be there by 300 s can walk for 90 s."""
    wish = a_wish(pickup_to_s=150.0, arrive_by_s=300.0)
    schedule = a_board()
    found = offered(schedule, wish, down=(Walk(2, walk_s),))
    assert [(a.kind, a.dropoff, a.arrival_s) for a in found] == (
        [("other_stops", 2, (210.0,))] if in_time else []
    )


def test_a_walk_at_both_ends_counts_twice() -> None:
    wish = a_wish(pickup_from_s=0.0, pickup_to_s=10.0, arrive_by_s=1000.0)
    (both,) = (a for a in offered(a_board(), wish, (Walk(0, 30.0),), (Walk(2, 40.0),)) if a.dropoff == 2)
    assert both.walk_s == 70.0


def test_nobody_is_sent_on_foot_to_the_stop_where_the_ride_should_end() -> None:
    found = offered(a_board(), a_wish(), up=(Walk(3, 20.0),), down=(Walk(1, 20.0),), later_s=600.0)
    assert {(a.pickup, a.dropoff) for a in found} == {(1, 3)}


def test_a_party_too_large_for_one_shuttle_is_offered_two() -> None:
    schedule = a_board(seats=2, shuttles=2)
    wish = a_wish(party=3, wheelchairs=0, pickup_to_s=200.0)
    (split,) = offered(schedule, wish)
    assert (split.kind, split.parties) == ("split_party", (2, 1))
    assert split.pickup_s == (100.0, 100.0)
    assert split.penalty_s == 300.0 + 100.0


def test_a_party_is_not_split_when_only_half_of_it_finds_room() -> None:
    assert offered(a_board(seats=2), a_wish(party=4, pickup_to_s=200.0)) == []
    assert offered(a_board(seats=2), a_wish(party=1, pickup_to_s=50.0)) == []


def test_the_nearest_come_first_few_and_each_once() -> None:
    walks = (Walk(0, 20.0), Walk(2, 60.0))
    found = offered(a_board(), a_wish(), up=walks, down=(Walk(2, 30.0),), later_s=900.0)
    assert 1 < len(found) <= OFFERED_MAX
    assert [a.penalty_s for a in found] == sorted(a.penalty_s for a in found)
    assert len({(a.pickup, a.dropoff) for a in found}) == len(found)


def test_asking_changes_nothing_on_the_board() -> None:
    schedule = a_board(seats=2, shuttles=2)
    before = schedule.rows.copy(), schedule.routes(None)
    offered(schedule, a_wish(party=3, pickup_to_s=200.0), up=(Walk(0, 20.0),), later_s=900.0)
    assert (schedule.rows, schedule.routes(None)) == before
