import math

import msgspec
import pytest

from contract.roads.areas import AreaAhead
from tests.vehicle_agent.planning.behaviour.jobs import FRONT_M, a_job
from tests.vehicle_agent.world.builders import some_tracks
from vehicle_agent.planning.behaviour.crossing_traffic import CrossingRules, YieldDecision, yielding
from vehicle_agent.signals import PEDESTRIAN, VEHICLE, PlanMemory, WatchedArea

RULES = CrossingRules(FRONT_M)
JUNCTION = AreaAhead("j", "intersection", 36.0, 38.0, 46.0)
CROSSING = AreaAhead("c", "crossing", 36.0, 38.0, 42.0)


def at_the_junction(
    *cars: tuple[int, float, float, float, float],
    s_m: float = 20.0,
    speed_mps: float = 3.0,
    stopping: bool = False,
) -> YieldDecision:
    tracks = some_tracks(*cars)
    watched = (WatchedArea("j", tuple(range(len(cars)))),)
    memory = PlanMemory(stopping_for=("j",) if stopping else ())
    job = a_job(tracks, speed_mps=speed_mps, areas=(JUNCTION,), watched=watched, memory=memory)
    return yielding(job, s_m, RULES)


def test_a_car_that_crosses_when_we_would_is_let_go_first_at_the_line() -> None:
    found = at_the_junction((VEHICLE, 42.0, 30.0, 0.0, -5.0))
    assert found.end_s_m == pytest.approx(36.0 - FRONT_M)
    assert found.to == (0,)
    assert found.stopping_for == ("j",)


def test_one_that_has_passed_long_before_is_no_reason_to_stop() -> None:
    assert math.isinf(at_the_junction((VEHICLE, 42.0, 4.0, 0.0, -8.0)).end_s_m)


def test_one_that_drives_away_from_our_way_is_none_either() -> None:
    assert math.isinf(at_the_junction((VEHICLE, 42.0, 8.0, 0.0, 5.0)).end_s_m)


def test_going_on_takes_more_room_than_stopping_did() -> None:
    """A car that has crossed two seconds before us: one who drives goes on, one who stopped waits."""
    car = (VEHICLE, 42.0, 12.0, 0.0, -5.0)
    assert math.isinf(at_the_junction(car).end_s_m)
    assert math.isfinite(at_the_junction(car, stopping=True).end_s_m)


def test_past_the_line_it_does_not_stop_among_those_who_cross() -> None:
    found = at_the_junction((VEHICLE, 42.0, 10.0, 0.0, -3.0), s_m=36.0)
    assert math.isinf(found.end_s_m)


def test_too_near_to_stop_comfortably_it_goes_on() -> None:
    assert math.isinf(at_the_junction((VEHICLE, 42.0, 10.0, 0.0, -5.0), s_m=31.5, speed_mps=4.0).end_s_m)


@pytest.mark.parametrize(
    ("ids", "told", "speed_mps"), [((0,), False, 2.2), ((), True, 1.5), ((), False, None)]
)
def test_a_crossing_is_passed_slowly_while_somebody_is_there_or_its_camera_says_so(
    ids: tuple[int, ...], told: bool, speed_mps: float | None
) -> None:
    tracks = some_tracks((PEDESTRIAN, 40.0, 3.0, 0.0, -1.0))
    job = a_job(tracks, areas=(CROSSING,), watched=(WatchedArea("c", ids, told),))
    found = yielding(job, 20.0, RULES)
    assert math.isinf(found.end_s_m)
    assert [slow[2] for slow in found.slow] == ([] if speed_mps is None else [speed_mps])


def test_a_camera_that_says_nobody_never_makes_it_go() -> None:
    """Somebody is seen although the camera tells of nobody: the sight counts."""
    tracks = some_tracks((PEDESTRIAN, 40.0, 3.0, 0.0, -1.0))
    job = a_job(tracks, areas=(CROSSING,), watched=(WatchedArea("c", (0,), False),))
    quiet = msgspec.structs.replace(job, watched=(WatchedArea("c", (0,), True),))
    assert yielding(job, 20.0, RULES) == yielding(quiet, 20.0, RULES)
