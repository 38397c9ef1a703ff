import math

import numpy as np
import pytest

from contract.roads.load import with_version
from contract.roads.model import Lane, Origin, RoadMap, Section
from contract.roads.network import RoadNetwork
from tests.vehicle_agent.mission.ring import NETWORK as RING
from tests.vehicle_agent.world.builders import some_tracks
from vehicle_agent.signals import PEDESTRIAN, VEHICLE
from vehicle_agent.world.prediction import Predictor


def a_bend() -> RoadNetwork:
    """30 m to the east, then a quarter circle to the left of radius 20 m, then north."""
    straight = [(float(x), 0.0) for x in range(31)]
    arc = [(30.0 + 20.0 * math.sin(a), 20.0 - 20.0 * math.cos(a)) for a in np.linspace(0.02, math.pi / 2, 40)]
    north = [(50.0, 20.0 + float(y)) for y in range(1, 40)]
    lane = Lane("bend", "road", tuple(straight + arc + north), 4.0, 8.0, False, ())
    section = Section("bend/0", "bend", 0.0, 95.0)
    return RoadNetwork(with_version(RoadMap("t", "t", Origin(31.0, 121.0), (lane,), (section,), (), (), ())))


def test_a_person_goes_straight_on_and_is_ever_less_certain() -> None:
    told = Predictor().predictions(some_tracks((PEDESTRIAN, 1.0, 2.0, 0.0, 1.4)), a_bend())
    at = int(np.flatnonzero(told.times_s == 3.0)[0])
    np.testing.assert_allclose(told.poses_map[0, at, :2], (1.0, 6.2))
    assert (np.diff(told.sigmas_m[0]) >= 0.0).all()
    assert told.sigmas_m[0, -1] > told.sigmas_m[0, 0]


def test_who_all_but_stands_is_not_predicted_away_by_noise() -> None:
    told = Predictor().predictions(some_tracks((PEDESTRIAN, 1.0, 2.0, 0.1, -0.1)), a_bend())
    np.testing.assert_allclose(told.poses_map[0, -1, :2], (1.0, 2.0))


def test_a_car_keeps_to_its_lane_around_the_bend() -> None:
    network = a_bend()
    told = Predictor().predictions(some_tracks((VEHICLE, 10.0, 0.5, 6.0, 0.0)), network)
    for pose in told.poses_map[0]:
        found = network.locate(*map(float, pose))
        assert found is not None
        assert found[2] == pytest.approx(0.5, abs=0.15)
    assert told.poses_map[0, -1, 1] > 15.0


def test_a_car_goes_on_into_the_lanes_that_follow_its_own() -> None:
    told = Predictor().predictions(some_tracks((VEHICLE, 60.0, 0.0, 6.0, 0.0)), RING)
    last = told.poses_map[0, -1]
    found = RING.locate(*map(float, last))
    assert found is not None
    assert (found[0], abs(found[2]) < 0.1) == ("east", True)
    assert RING.lines["south"].length_m - 60.0 + found[1] == pytest.approx(6.0 * told.times_s[-1], abs=0.1)


@pytest.mark.parametrize(
    "row",
    [(VEHICLE, 10.0, 6.0, 6.0, 0.0), (VEHICLE, 10.0, 0.0, 0.0, 6.0), (VEHICLE, 10.0, 0.0, 4.0, 4.0)],
)
def test_a_car_beside_or_across_a_lane_goes_straight_on(row: tuple[int, float, float, float, float]) -> None:
    told = Predictor().predictions(some_tracks(row), a_bend())
    straight = np.array(row[1:3]) + told.times_s[:, None] * np.array(row[3:])
    np.testing.assert_allclose(told.poses_map[0, :, :2], straight)


def test_how_uncertain_a_place_is_grows_with_time_by_who_moves_and_half_as_fast_for_who_stands() -> None:
    rows = (
        (PEDESTRIAN, 1.0, 30.0, 0.0, 1.4),
        (VEHICLE, 1.0, 40.0, 0.0, 3.0),
        (PEDESTRIAN, 1.0, 50.0, 0.1, 0.0),
        (VEHICLE, 1.0, 60.0, 0.0, 0.0),
    )
    room = Predictor()
    told = room.predictions(some_tracks(*rows), a_bend())
    at = int(np.flatnonzero(told.times_s == 2.0)[0])
    assert told.sigmas_m[:, 0].tolist() == [0.1] * 4
    assert told.sigmas_m[:, at].tolist() == pytest.approx([0.5, 0.8, 0.3, 0.45])
    assert told.sigmas_m.max() == room.std_m_max
    assert told.times_s[-1] == room.horizon_s


def test_beyond_the_end_of_the_road_a_car_goes_straight_on() -> None:
    told = Predictor().predictions(some_tracks((VEHICLE, 50.0, 50.0, 0.0, 6.0)), a_bend())
    assert told.poses_map[0, :, 0] == pytest.approx(50.0, abs=0.01)
    assert told.poses_map[0, :, 1] == pytest.approx(50.0 + 6.0 * told.times_s, abs=0.01)


@pytest.mark.parametrize(("speed_mps", "keeps"), [(0.9, False), (1.1, True)])
def test_a_car_keeps_to_its_lane_once_it_clearly_drives(speed_mps: float, keeps: bool) -> None:
    told = Predictor().predictions(some_tracks((VEHICLE, 28.0, 0.0, speed_mps, 0.0)), a_bend())
    assert bool(told.poses_map[0, -1, 1] > 0.5) is keeps
