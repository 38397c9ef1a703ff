"""Every defect of a map is found and named."""

import math
from collections.abc import Callable
from typing import Any

import pytest
from msgspec.structs import replace

from contract.roads.load import content_version, load_map
from contract.roads.model import (
    Kerb,
    Lane,
    NoStoppingZone,
    ObservationArea,
    RestingPlace,
    RoadMap,
    Section,
    Stop,
    TimetableTrip,
)
from contract.roads.validate import problems
from tests.contract.roads.generated_maps import generated_map
from tests.contract.roads.ring_map import ring_map
from tests.server.feeds.roads.shipped import CAMPUS_MAP, SNOW_LION_MAP


def _lane(change: Callable[[Lane], Lane], number: int = 0) -> Callable[[RoadMap], RoadMap]:
    def changed(road_map: RoadMap) -> RoadMap:
        lanes = list(road_map.lanes)
        lanes[number] = change(lanes[number])
        return replace(road_map, lanes=tuple(lanes))

    return changed


def _first_section(**changes: Any) -> Callable[[RoadMap], RoadMap]:
    def changed(road_map: RoadMap) -> RoadMap:
        first: Section = replace(road_map.sections[0], **changes)
        return replace(road_map, sections=(first, *road_map.sections[1:]))

    return changed


def _bent(lane: Lane) -> Lane:
    moved = tuple((x, y + 0.3 * (k % 2)) for k, (x, y) in enumerate(lane.points[1:-1]))
    return replace(lane, points=(lane.points[0], *moved, lane.points[-1]))


def _area(**changes: Any) -> Callable[[RoadMap], RoadMap]:
    area = ObservationArea("a", "crossing", ((38, -4), (42, -4), (42, 4), (38, 4)), (("side-0", 37.5),))
    return lambda road_map: replace(road_map, observation_areas=(replace(area, **changes),))


def _zone(**changes: Any) -> Callable[[RoadMap], RoadMap]:
    zone = NoStoppingZone("z", "side-0", 20.0, 30.0)
    return lambda road_map: replace(road_map, no_stopping_zones=(replace(zone, **changes),))


def _kerb(points: tuple[tuple[float, float], ...]) -> Callable[[RoadMap], RoadMap]:
    return lambda road_map: replace(road_map, kerbs=(Kerb("k", points),))


SECOND_PLACE = RestingPlace("r", "side-1", 20.0)

DEFECTS: list[tuple[str, Callable[[RoadMap], RoadMap]]] = [
    ("empty", lambda m: replace(m, stops=())),
    ("empty", lambda m: replace(m, resting_places=())),
    ("empty", lambda m: replace(m, lanes=(), sections=(), stops=(), resting_places=())),
    ("doubled_id", lambda m: replace(m, stops=(*m.stops, m.stops[0]))),
    ("dangling_id", _lane(lambda lane: replace(lane, successors=("nowhere",)))),
    ("dangling_id", _first_section(lane_id="nowhere")),
    ("dangling_id", _first_section(conflicts=("nowhere",))),
    ("dangling_id", lambda m: replace(m, stops=(Stop("s", "S", "nowhere", 1.0),))),
    ("dangling_id", lambda m: replace(m, resting_places=(RestingPlace("r", "nowhere", 1.0),))),
    ("dangling_id", lambda m: replace(m, timetable=(TimetableTrip("t", (("nowhere", 0),)),))),
    ("dangling_id", _zone(lane_id="nowhere")),
    ("bad_zone", _zone(s_to_m=100.5)),
    ("bad_zone", _zone(s_from_m=30.0)),
    ("in_no_stopping_zone", _zone(s_from_m=62.0, s_to_m=70.0)),
    ("in_no_stopping_zone", _zone(lane_id="side-3")),
    ("bad_kerb", _kerb(((0.0, 3.0),))),
    ("bad_kerb", _kerb(((0.0, 3.0), (math.nan, 3.0)))),
    ("kerb_in_the_way", _kerb(((-5.0, 3.0), (50.0, 0.8)))),
    ("kerb_in_the_way", _kerb(((50.0, 40.0), (50.0, -40.0)))),
    ("bad_width", _lane(lambda lane: replace(lane, width_m=0.0))),
    ("dangling_id", _area(stop_lines=(("nowhere", 1.0),))),
    ("doubled_id", lambda m: replace(m, observation_areas=_area()(m).observation_areas * 2)),
    ("off_lane", _area(stop_lines=(("side-0", 100.5),))),
    ("bad_outline", _area(outline=((0, 0), (2, 2), (2, 0), (0, 2)))),
    ("bad_outline", _area(outline=((0, 0), (2, 2)))),
    ("bad_outline", _area(outline=((0, 0), (2, 0), (math.inf, 2)))),
    ("too_few_points", _lane(lambda lane: replace(lane, points=lane.points[:1]))),
    ("not_finite", _lane(lambda lane: replace(lane, points=((math.nan, 0.0), *lane.points[1:])))),
    ("bad_speed", _lane(lambda lane: replace(lane, speed_limit_mps=0.0))),
    ("points_apart", _lane(lambda lane: replace(lane, points=(*lane.points[:40], *lane.points[45:])))),
    ("points_doubled", _lane(lambda lane: replace(lane, points=(lane.points[0], *lane.points)))),
    ("too_sharp", _lane(_bent)),
    ("gap", _lane(lambda lane: replace(lane, points=lane.points[:-1]))),
    ("kink", _lane(lambda lane: replace(lane, points=tuple((x, -0.3 * (100 - x)) for x, _ in lane.points)))),
    ("untiled", lambda m: replace(m, sections=m.sections[1:])),
    ("untiled", _first_section(s_to_m=20.0)),
    ("lopsided_conflict", _first_section(conflicts=("side-2/0",))),
    ("lopsided_conflict", _first_section(conflicts=("side-0/0",))),
    ("off_lane", lambda m: replace(m, stops=(Stop("s", "S", "side-0", 101.0), *m.stops))),
    ("cut_off", _lane(lambda lane: replace(lane, successors=()), number=3)),
    ("broken_promise", lambda m: replace(m, resting_places=(*m.resting_places, SECOND_PLACE))),
    ("tight_place", lambda m: replace(m, resting_places=(RestingPlace("r", "side-3", 24.0),))),
]  # fmt: skip


def test_a_sound_map_has_no_problems() -> None:
    assert problems(ring_map()) == ()


@pytest.mark.parametrize(("code", "damage"), DEFECTS)
def test_each_defect_is_named(code: str, damage: Callable[[RoadMap], RoadMap]) -> None:
    found = problems(damage(ring_map()))
    assert code in {problem.code for problem in found}
    assert all(problem.where and problem.detail for problem in found)


@pytest.mark.parametrize("path", [CAMPUS_MAP, SNOW_LION_MAP], ids=["campus", "snow-lion"])
def test_the_shipped_maps_are_sound(path: Any) -> None:
    assert problems(load_map(path)) == ()


@pytest.mark.parametrize("seed", range(6, 14))
def test_made_up_campuses_become_sound_maps(seed: int) -> None:
    assert problems(generated_map(seed)) == ()


def _codes(road_map: RoadMap) -> set[str]:
    return {problem.code for problem in problems(road_map)}


def _of_points(count: int) -> Callable[[Lane], Lane]:
    return lambda lane: replace(lane, points=lane.points[:count])


def _with_gap(gap_m: float) -> Callable[[Lane], Lane]:
    """The lane's second point so far from its first."""
    return lambda lane: replace(lane, points=(lane.points[0], (gap_m, 0.0), *lane.points[2:]))


def _shifted(along_m: float, aside_m: float) -> Callable[[Lane], Lane]:
    return lambda lane: replace(lane, points=tuple((x + along_m, y + aside_m) for x, y in lane.points))


def _turned(by_rad: float) -> Callable[[Lane], Lane]:
    """Swung around its end, where the next lane begins."""

    def swung(lane: Lane) -> Lane:
        end_x, _ = lane.points[-1]
        points = tuple(
            (end_x + (x - end_x) * math.cos(by_rad), (x - end_x) * math.sin(by_rad)) for x, _ in lane.points
        )
        return replace(lane, points=points)

    return swung


def _round(radius_m: float) -> Callable[[Lane], Lane]:
    """A full circle."""
    count = math.ceil(2.0 * math.pi * radius_m / 0.5)
    angles = [2.0 * math.pi * k / count for k in range(count + 1)]
    return lambda lane: replace(
        lane, points=tuple((radius_m * math.sin(a), radius_m * (1.0 - math.cos(a))) for a in angles)
    )


def _stop_at(s_m: float) -> Callable[[RoadMap], RoadMap]:
    return lambda m: replace(m, stops=(Stop("s", "S", "side-0", s_m), *m.stops))


def _rest_at(s_m: float) -> Callable[[RoadMap], RoadMap]:
    return lambda m: replace(m, resting_places=(RestingPlace("r", "side-3", s_m),))


# Sections of side-3 are 25 m long; a shuttle reaches 0.875 m back and 3.475 m ahead of its rear axle.
@pytest.mark.parametrize(
    ("code", "sound", "damaged"),
    [
        ("too_few_points", _lane(_of_points(2)), _lane(_of_points(1))),
        ("points_apart", _lane(_with_gap(1.0)), _lane(_with_gap(0.9))),
        ("gap", _lane(_shifted(0.019, 0.0)), _lane(_shifted(0.021, 0.0))),
        ("kink", _lane(_turned(0.059)), _lane(_turned(0.061))),
        ("kink", _lane(_turned(-0.059)), _lane(_turned(-0.061))),
        ("too_sharp", _lane(_round(4.95)), _lane(_round(4.8))),
        ("untiled", _first_section(s_from_m=0.0009), _first_section(s_from_m=0.0011)),
        ("off_lane", _stop_at(100.0), _stop_at(100.01)),
        ("off_lane", _stop_at(0.0), _stop_at(-0.01)),
        ("tight_place", _rest_at(25.0 + 0.876), _rest_at(25.0 + 0.874)),
        ("tight_place", _rest_at(25.0 - 3.476), _rest_at(25.0 - 3.474)),
    ],
)
def test_each_limit_holds_from_both_sides(
    code: str, sound: Callable[[RoadMap], RoadMap], damaged: Callable[[RoadMap], RoadMap]
) -> None:
    assert code not in _codes(sound(ring_map()))
    assert code in _codes(damaged(ring_map()))


@pytest.mark.parametrize(
    "doubled",
    [
        lambda m: replace(m, lanes=(*m.lanes, m.lanes[0])),
        lambda m: replace(m, sections=(*m.sections, m.sections[0])),
        lambda m: replace(m, resting_places=m.resting_places * 2),
        lambda m: replace(m, timetable=(TimetableTrip("t", (("stop-0", 0),)),) * 2),
    ],
)
def test_every_kind_of_id_is_used_once(doubled: Callable[[RoadMap], RoadMap]) -> None:
    (problem,) = problems(doubled(ring_map()))
    assert (problem.code, problem.detail) == ("doubled_id", "used 2 times")


def test_every_defect_is_named_at_its_place() -> None:
    two = replace(
        ring_map(),
        stops=(Stop("far", "S", "side-0", 101.0), Stop("before", "S", "side-1", -1.0), *ring_map().stops),
    )
    assert [(problem.code, problem.where) for problem in problems(two)] == [
        ("off_lane", "far"),
        ("off_lane", "before"),
    ]


def test_a_zone_away_from_stops_and_a_kerb_beside_the_road_are_no_defects() -> None:
    road_map = _zone()(_kerb(((5.0, 1.5), (95.0, 1.5)))(ring_map()))
    assert problems(road_map) == ()


def test_maps_without_zones_and_kerbs_keep_their_version() -> None:
    assert content_version(load_map(CAMPUS_MAP)) == load_map(CAMPUS_MAP).map_version
    assert content_version(_zone()(ring_map())) != ring_map().map_version
