import math

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.areas import AreaAhead
from tests.vehicle_agent.planning.behaviour.jobs import RULES, a_job
from tests.vehicle_agent.world.builders import some_tracks
from vehicle_agent.planning.behaviour.decide import decide
from vehicle_agent.planning.behaviour.scenarios import PARKING_LOT
from vehicle_agent.signals import PEDESTRIAN, VEHICLE, View, WatchedArea


def test_a_free_road_is_driven_in_the_middle_to_the_stop() -> None:
    decision = decide(a_job(stop_s_m=70.0), RULES)
    assert decision.s_m == pytest.approx(20.0)
    assert (decision.reference_l_m == 0.0).all()
    assert (decision.end_s_m, decision.end_reason) == (70.0, "stop")
    assert math.isinf(decision.cut_s_m)


def test_a_wall_across_the_road_cuts_the_route_before_it() -> None:
    wall = tuple((45.0, float(y)) for y in np.arange(-3.0, 3.1, 0.2))
    decision = decide(a_job(points=wall), RULES)
    assert decision.end_reason == "obstacle"
    bumper_m = decision.end_s_m + RULES.front_m
    assert 42.0 < bumper_m < 44.5


def test_a_parked_car_at_the_side_is_passed_on_the_other() -> None:
    decision = decide(a_job(some_tracks((VEHICLE, 40.0, 1.6, 0.0, 0.0))), RULES)
    assert decision.chosen.offset_m <= 0.0
    assert math.isinf(decision.cut_s_m) or decision.chosen.better_offset_m < 0.0


def test_the_room_of_the_road_bounds_every_offset() -> None:
    decision = decide(a_job(), RULES)
    assert decision.upper_l_m == pytest.approx(2.5 - 0.815 - RULES.wall_m)
    assert (decision.lower_l_m == -decision.upper_l_m).all()


def test_a_parking_lot_is_slower_and_people_are_taken_wider_there() -> None:
    walker = some_tracks((PEDESTRIAN, 40.0, 3.0, 0.0, -1.0))
    road, lot = (decide(a_job(walker, scenario=name), RULES) for name in ("common_road", "parking_lot"))
    assert lot.speed_mps_max.max() == PARKING_LOT.speed_mps_max < road.speed_mps_max.max()
    assert (lot.inflation_m >= road.inflation_m).all()
    assert lot.inflation_m[0, 0] > road.inflation_m[0, 0]


def test_who_is_predicted_less_surely_is_taken_wider_but_never_without_end() -> None:
    decision = decide(a_job(some_tracks((PEDESTRIAN, 40.0, 3.0, 0.0, -1.0))), RULES)
    assert (np.diff(decision.inflation_m[0]) >= 0.0).all()
    assert decision.inflation_m.max() <= RULES.inflation_m_max


def test_a_crossing_with_somebody_at_it_is_slow_and_its_reason_is_told() -> None:
    area = AreaAhead("c", "crossing", 36.0, 38.0, 42.0)
    decision = decide(a_job(areas=(area,), watched=(WatchedArea("c", (), True),)), RULES)
    station = int(np.searchsorted(decision.stations_m, 38.0))
    assert decision.speed_mps_max[station] == 1.5
    assert decision.reasons[station] == "crossing"


def test_a_place_that_nobody_can_see_into_is_approached_slowly() -> None:
    """Something 6 m ahead on the right hides all that is behind it."""
    bearings = -math.pi + (np.arange(720) + 0.5) * 2.0 * math.pi / 720
    ranges = np.full(720, 40.0)
    hidden = (bearings < math.atan2(-1.6, 10.0)) & (bearings > math.atan2(-1.6, 3.0))
    ranges[hidden] = 1.6 / np.sin(-bearings[hidden])
    view = View(Pose2(23.2, 0.0, 0.0), ranges)
    blind, clear = decide(a_job(view=view), RULES), decide(a_job(), RULES)
    assert blind.speed_mps_max.min() < clear.speed_mps_max.min() - 0.5
    assert "occlusion" in blind.reasons
