"""What is said of percepts: missed, late, in cells, and how much of a road user was seen."""

import numpy as np

from benchmarks.percepts.sightings import (
    NEVER_AFTER_SCANS,
    NEW_AFTER_SCANS,
    Sighting,
    appearances,
    seen_shares,
    sightings,
)
from contract.geometry import Pose2
from simulator.traffic.actors import Bodies
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE, ObstaclePercept, TrackPercept

GRID = PointGrid(2.5, 3.0, 1.0, 0.9)
# The vehicle stands at (100, 50) and looks north: 10 m ahead is (100, 60).
POSE = Pose2(100.0, 50.0, 0.5 * np.pi)


def bodies(*placed: tuple[int, float, float, float]) -> Bodies:
    """kind, x, y, yaw in the map."""
    kinds = np.array([kind for kind, *_ in placed], np.int64)
    poses = np.array([pose for _, *pose in placed])
    sizes = np.array(
        [{PEDESTRIAN: (0.5, 0.5), CYCLIST: (1.75, 0.6), VEHICLE: (4.3, 1.8)}[int(k)] for k in kinds]
    )
    return Bodies(np.arange(len(placed)), kinds, poses, np.zeros((len(placed), 2)), sizes)


def cells_at(*places: tuple[float, float]) -> ObstaclePercept:
    return ObstaclePercept(0, np.array(places).reshape(-1, 2), np.ones(len(places)), 1)


def tracks_at(*placed: tuple[int, float, float]) -> TrackPercept:
    n = len(placed)
    poses = np.array([(x, y, 0.0) for _, x, y in placed]).reshape(-1, 3)
    kinds = np.array([kind for kind, *_ in placed], np.int64)
    return TrackPercept(0, np.arange(n), kinds, poses, np.zeros((n, 2)), np.ones((n, 2)))


def test_a_road_user_is_found_where_it_is_whatever_its_heading() -> None:
    # A car across the way, 12 m ahead; a person beside it, and one behind the reach.
    others = bodies(
        (VEHICLE, 100.0, 62.0, 0.0), (PEDESTRIAN, 97.0, 62.0, 0.0), (PEDESTRIAN, 100.0, 30.0, 0.0)
    )
    points = np.array(
        [(12.0, 2.0, 1.0), (12.0, -2.0, 1.0), (12.0, 3.0, 1.0), (12.0, 0.0, 0.1), (12.0, 0.0, 3.0)]
    )
    car, person = sightings(
        7,
        points,
        others,
        POSE,
        cells_at((12.0, 1.8)),
        tracks_at((VEHICLE, 12.3, -0.4), (CYCLIST, 12.0, 3.4)),
        GRID,
    )
    assert (car.number, car.returns, car.tracked, car.named, car.in_cells) == (0, 2, True, True, True)
    assert (person.number, person.returns, person.tracked, person.named) == (1, 1, True, False)
    assert not person.in_cells
    assert abs(person.range_m - np.hypot(12.0, 3.0)) < 1e-6


def test_a_velocity_is_compared_in_the_vehicles_frame_and_with_the_nearest_track_of_the_kind() -> None:
    others = bodies((PEDESTRIAN, 97.0, 62.0, 0.0))
    # West in the map is to the left of a vehicle that looks north.
    others.velocities_map_mps[:] = (-1.2, 0.0)
    near, far = (PEDESTRIAN, 12.1, 3.0), (PEDESTRIAN, 12.5, 3.3)
    tracks = tracks_at(far, near, (CYCLIST, 12.0, 3.0))
    tracks.velocities_base_mps[:] = (5.0, 5.0), (0.0, 0.9), (5.0, 5.0)
    (person,) = sightings(0, np.zeros((0, 3)), others, POSE, cells_at(), tracks, GRID)
    assert person.velocity_off_mps is not None
    assert abs(person.velocity_off_mps - 0.3) < 1e-9
    cyclist = tracks_at((CYCLIST, 12.0, 3.0))
    (unnamed,) = sightings(0, np.zeros((0, 3)), others, POSE, cells_at(), cyclist, GRID)
    assert unnamed.velocity_off_mps is None


def test_who_stands_in_a_car_is_left_out_and_so_is_the_car() -> None:
    others = bodies(
        (VEHICLE, 100.0, 62.0, 0.0), (PEDESTRIAN, 101.5, 62.5, 1.0), (PEDESTRIAN, 101.5, 63.4, 1.0)
    )
    (beside,) = sightings(0, np.zeros((0, 3)), others, POSE, cells_at(), tracks_at(), GRID)
    assert beside.number == 2


def test_a_share_is_of_what_one_of_its_kind_in_full_view_has_there() -> None:
    found = [seen(k, k, returns=100) for k in range(9)] + [seen(9, 9, returns=20)]
    found += [seen(20 + k, 0, kind=VEHICLE, returns=1000) for k in range(3)]
    shares = seen_shares(found)
    assert shares[:9].tolist() == [1.0] * 9
    assert abs(shares[9] - 0.2) < 1e-9
    assert shares[10:].tolist() == [1.0] * 3


def seen(
    scan: int,
    number: int,
    *,
    returns: int = 50,
    tracked: bool = True,
    in_cells: bool = True,
    kind: int = PEDESTRIAN,
) -> Sighting:
    return Sighting(scan, number, kind, 10.5, returns, tracked, tracked, in_cells)


def test_delays_count_from_the_first_scan_in_view() -> None:
    hidden = [seen(scan, 1, returns=2, tracked=False, in_cells=False) for scan in range(NEW_AFTER_SCANS)]
    view = [
        seen(scan, 1, tracked=scan >= NEW_AFTER_SCANS + 3, in_cells=scan >= NEW_AFTER_SCANS + 1)
        for scan in range(NEW_AFTER_SCANS, NEW_AFTER_SCANS + 20)
    ]
    (told,) = appearances(hidden + view)
    assert (told.track_after, told.cell_after) == (3, 1)


def test_who_was_in_view_from_the_beginning_has_no_delay_and_who_is_never_tracked_is_told() -> None:
    from_the_beginning = [seen(scan, 1, tracked=False) for scan in range(40)]
    into_reach = [seen(scan, 2, tracked=False) for scan in range(15, 15 + NEVER_AFTER_SCANS)]
    gone_at_once = [seen(scan, 3, tracked=False) for scan in range(15, 15 + NEVER_AFTER_SCANS - 1)]
    (told,) = appearances(from_the_beginning + into_reach + gone_at_once)
    assert (told.track_after, told.cell_after) == (None, 0)
