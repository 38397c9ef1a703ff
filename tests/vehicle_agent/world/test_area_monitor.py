"""Which people in or near a crossing the shuttle has to expect on it."""

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.model import ObservationArea
from tests.vehicle_agent.world.builders import some_tracks
from vehicle_agent.signals import PEDESTRIAN, PedestrianPresence, Predictions, Tracks
from vehicle_agent.world.area_monitor import AreaMonitor, outlines_of
from vehicle_agent.world.prediction import straight_on

# 10 m by 4 m, seen from the origin 20 m ahead.
OUTLINE = ((20.0, -2.0), (30.0, -2.0), (30.0, 2.0), (20.0, 2.0))
AREA = ObservationArea("gate", "crossing", OUTLINE, ())
ROOM = AreaMonitor()
TIMES_S = np.arange(13) * 0.25


def predicted(tracks: Tracks) -> Predictions:
    poses = straight_on(tracks.poses_map, tracks.velocities_map_mps, TIMES_S)
    return Predictions(1, TIMES_S, poses, np.ones((len(tracks.ids), len(TIMES_S))))


def expected(
    *people: tuple[float, float, float, float], x_m: float = 0.0, y_m: float = 0.0, count: int = -1
) -> tuple[tuple[int, ...], bool] | None:
    """(tracks expected in the area, whether a camera reports people) with the shuttle at x_m, y_m."""
    tracks = some_tracks(*((PEDESTRIAN, *row) for row in people))
    presence = () if count < 0 else (PedestrianPresence(1, "gate", count),)
    found = ROOM.watched(
        (AREA,), outlines_of((AREA,)), Pose2(x_m, y_m, 0.0), tracks, predicted(tracks), presence
    )
    return (found[0].track_ids, found[0].reported) if found else None


def test_who_walks_in_the_area_or_is_in_it_within_two_seconds_is_expected() -> None:
    inside, soon, late = (25.0, 0.0, 0.0, 1.0), (25.0, -3.9, 0.0, 1.0), (25.0, -6.0, 0.0, 1.0)
    assert expected(inside, soon, late) == ((0, 1), False)


def test_who_stands_in_the_area_is_an_obstacle_and_no_crossing_traffic() -> None:
    assert expected((25.0, 0.0, 0.0, 0.3), (25.0, 1.0, 0.0, 0.4)) == ((1,), False)


@pytest.mark.parametrize(
    ("x_m", "y_m", "near"),
    [
        (-24.9, 0.0, True),
        (-25.1, 0.0, False),
        (74.9, 0.0, True),
        (75.1, 0.0, False),
        (25.0, 46.9, True),
        (25.0, 47.1, False),
        (25.0, -46.9, True),
        (25.0, -47.1, False),
        # Neither axis alone is too far, the corner is.
        (-12.0, 36.0, False),
    ],
)
def test_areas_within_45_metres_of_the_shuttle_are_watched(x_m: float, y_m: float, near: bool) -> None:
    assert (expected(x_m=x_m, y_m=y_m) is not None) == near


def test_a_camera_that_counts_somebody_is_reported_and_one_that_counts_nobody_is_not() -> None:
    assert expected(count=1) == ((), True)
    assert expected(count=0) == ((), False)
