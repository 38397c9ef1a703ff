"""Percepts in the map frame, the blind zone, and a blind sensor."""

import math

import numpy as np

from contract.geometry import Pose2
from vehicle_agent.perception.cells import CellsState, HeightMapPerception
from vehicle_agent.signals import Detections, Ego, ObstaclePercept

ROOM = HeightMapPerception(3.2, 2.28, math.radians(-15.0), 3.5, 0.85, 0.815)
TICK_NS = 20_000_000


def an_ego(now_ns: int, x_m: float = 0.0, yaw_rad: float = 0.0) -> Ego:
    return Ego(now_ns, Pose2(x_m, 0.0, yaw_rad), 2.0, 0.0, 0.0, 0.0, 0.02, now_ns, True)


def a_percept(stamp_ns: int, *cells: tuple[float, float], used: int = 100) -> ObstaclePercept:
    return ObstaclePercept(stamp_ns, np.array(cells).reshape(-1, 2), np.ones(len(cells)), used)


def told(
    state: CellsState, now_ns: int, percept: ObstaclePercept, x_m: float = 0.0
) -> tuple[Detections, CellsState]:
    return ROOM.step(state, (percept,), an_ego(now_ns, x_m))


def test_cells_are_moved_with_the_pose_at_the_scan_and_not_of_now() -> None:
    state = ROOM.initial()
    for k in range(1, 11):
        _, state = ROOM.step(state, (), an_ego(k * TICK_NS, 0.04 * k))
    seen, _ = told(state, 11 * TICK_NS, a_percept(5 * TICK_NS, (10.0, 1.0)), 0.44)
    np.testing.assert_allclose(seen.points_map, [[10.2, 1.0]], atol=1e-8)


def test_the_same_object_is_given_until_the_next_scan() -> None:
    seen, state = told(ROOM.initial(), TICK_NS, a_percept(TICK_NS, (10.0, 0.0)))
    again, _ = ROOM.step(state, (), an_ego(2 * TICK_NS))
    assert again is seen


def test_an_older_scan_that_comes_late_changes_nothing() -> None:
    seen, state = told(ROOM.initial(), 9 * TICK_NS, a_percept(9 * TICK_NS, (10.0, 0.0)))
    again, _ = told(state, 10 * TICK_NS, a_percept(5 * TICK_NS, (20.0, 0.0)))
    assert again is seen


def test_a_scan_that_comes_twice_is_looked_at_once() -> None:
    seen, state = told(ROOM.initial(), 9 * TICK_NS, a_percept(9 * TICK_NS, (10.0, 0.0)))
    again, _ = told(state, 10 * TICK_NS, a_percept(9 * TICK_NS, (10.0, 0.0)))
    assert again is seen


def test_a_blind_sensor_forgets_nothing_and_says_so() -> None:
    _, state = told(ROOM.initial(), TICK_NS, a_percept(TICK_NS, (10.0, 0.0)))
    seen, _ = told(state, 6 * TICK_NS, a_percept(6 * TICK_NS, used=0))
    assert seen.blind
    assert len(seen.points_map) == 1


def test_who_vanishes_under_the_lowest_ring_is_remembered_for_a_while() -> None:
    near, seen_ns = (5.0, 0.3), 3600 * 1_000_000_000
    _, state = told(ROOM.initial(), seen_ns, a_percept(seen_ns, near))
    later_ns = seen_ns + ROOM.memory_ns // 2
    seen, state = told(state, later_ns, a_percept(later_ns))
    np.testing.assert_allclose(seen.points_map, [near], atol=1e-8)
    over_ns = seen_ns + ROOM.memory_ns + 100_000_000
    seen, _ = told(state, over_ns, a_percept(over_ns))
    assert len(seen.points_map) == 0


def test_who_walks_away_in_sight_is_not_remembered() -> None:
    _, state = told(ROOM.initial(), TICK_NS, a_percept(TICK_NS, (12.0, 0.3)))
    seen, _ = told(state, 6 * TICK_NS, a_percept(6 * TICK_NS, (12.0, 3.0)))
    np.testing.assert_allclose(seen.points_map, [[12.0, 3.0]], atol=1e-8)


def test_who_is_seen_again_nearby_is_not_doubled() -> None:
    _, state = told(ROOM.initial(), TICK_NS, a_percept(TICK_NS, (5.0, 0.3)))
    seen, _ = told(state, 6 * TICK_NS, a_percept(6 * TICK_NS, (5.2, 0.4)))
    assert len(seen.points_map) == 1


def remembered(
    near: tuple[float, float], *then: tuple[float, float], x_m: float = 0.0
) -> list[tuple[float, float]]:
    """What is known of a cell in the scan after the one that showed it, which shows `then`."""
    _, state = told(ROOM.initial(), TICK_NS, a_percept(TICK_NS, near))
    seen, _ = told(state, 6 * TICK_NS, a_percept(6 * TICK_NS, *then), x_m)
    return [(round(float(x), 6), round(float(y), 6)) for x, y in seen.points_map]


def test_what_was_hidden_counts_as_seen_again_within_sixty_centimetres() -> None:
    assert remembered((5.0, 0.3), (5.58, 0.3)) == [(5.58, 0.3)]
    assert remembered((5.0, 0.3), (5.62, 0.3)) == [(5.62, 0.3), (5.0, 0.3)]
    assert remembered((5.0, 0.3), (5.0, 1.0)) == [(5.0, 1.0), (5.0, 0.3)]


def test_the_blind_zone_is_where_the_lowest_ring_passes_over_a_child() -> None:
    """A ring at -15 degrees from 2.28 m is down at 1.4 m after 3.28 m; 0.4 m more are for noise."""
    reach_m = 0.88 / math.tan(math.radians(15.0)) + 0.4
    for x, y in ((3.2 + reach_m, 0.0), (3.2, reach_m), (3.2, -reach_m)):
        inside = (3.2 + 0.99 * (x - 3.2), 0.99 * y)
        outside = (3.2 + 1.01 * (x - 3.2), 1.01 * y)
        assert len(remembered(inside)) == 1
        assert remembered(outside) == []


def test_nobody_is_remembered_inside_the_own_body() -> None:
    """The vehicle has driven over the place; what lies there now is itself."""
    assert remembered((5.0, 0.3), x_m=1.0) == [(5.0, 0.3)]
    assert remembered((5.0, 0.3), x_m=2.0) == []
    assert remembered((5.0, 0.83), x_m=2.0) == [(5.0, 0.83)]


def test_who_comes_into_the_blind_zone_because_the_vehicle_drives_on_is_remembered() -> None:
    assert remembered((7.5, 0.2), x_m=0.7) == [(7.5, 0.2)]


def test_two_scans_at_once_count_as_the_newer_one() -> None:
    percepts = (a_percept(3 * TICK_NS, (20.0, 0.0)), a_percept(2 * TICK_NS, (10.0, 0.0)))
    seen, _ = ROOM.step(ROOM.initial(), percepts, an_ego(3 * TICK_NS))
    np.testing.assert_allclose(seen.points_map, [[20.0, 0.0]], atol=1e-8)
    assert seen.stamp_ns == 3 * TICK_NS


RESTING = HeightMapPerception(3.2, 2.28, math.radians(-15.0), 3.5, 0.85, 0.815, rest_memory_ns=60_000_000_000)
SCAN_NS = 100_000_000


class Rest:
    """A vehicle that stands, scan after scan."""

    def __init__(self, room: HeightMapPerception = RESTING) -> None:
        self.room, self.state, self.now_ns = room, room.initial(), SCAN_NS

    def scan(self, *cells: tuple[float, float], speed_mps: float = 0.0, scans: int = 1) -> Detections:
        for _ in range(scans):
            self.now_ns += SCAN_NS
            ego = Ego(
                self.now_ns, Pose2(0.0, 0.0, 0.0), speed_mps, 0.0, 0.0, 0.0, 0.02, self.now_ns, True
            )  # fmt: skip
            percept = a_percept(self.now_ns, *cells)
            seen, self.state = self.room.step(self.state, (percept,), ego)
        return seen


def test_who_stands_before_a_vehicle_at_rest_is_remembered_until_they_leave() -> None:
    rest = Rest()
    rest.scan((5.0, 0.3))
    assert len(rest.scan(scans=500).points_map) == 1
    seen = rest.scan((7.2, 1.0))
    assert seen.points_map.tolist() == [[7.2, 1.0]], "who appears beside the blind zone is them"


def test_a_vehicle_that_drives_remembers_for_a_short_time_only() -> None:
    rest = Rest()
    rest.scan((5.0, 0.3))
    assert len(rest.scan(scans=50, speed_mps=0.5).points_map) == 0


def test_who_has_stood_there_all_along_is_not_who_leaves() -> None:
    rest = Rest()
    rest.scan((7.3, 1.0), scans=10)
    rest.scan((5.0, 0.3), (7.3, 1.0))
    assert len(rest.scan((7.3, 1.0), scans=100).points_map) == 2


def test_who_appears_too_far_away_is_not_who_stood_there() -> None:
    rest = Rest()
    rest.scan((5.0, 0.3))
    rest.scan(scans=5)
    rest.scan((15.0, 4.0), scans=100)
    assert [5.0, 0.3] in rest.scan((15.0, 4.0)).points_map.tolist()


def test_who_leaves_soon_is_forgotten_as_soon_as_before() -> None:
    rest = Rest()
    rest.scan((5.0, 0.3))
    rest.scan(scans=5)
    rest.scan((7.2, 0.8))
    assert len(rest.scan((12.0, 0.8), scans=40).points_map) == 1


def test_at_last_the_vehicle_goes_on() -> None:
    rest = Rest()
    rest.scan((5.0, 0.3))
    assert len(rest.scan(scans=605).points_map) == 0
