"""The height map: who is seen, and what ground is not."""

import math

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.model import Building
from simulator.sensors.lidar import Lidar, LidarNoise
from simulator.sensors.walls import WallScene
from vehicle_agent.config import Body, LidarMount, Profile
from vehicle_agent.perception.height_map import percept_from_scan
from vehicle_agent.stacks.rooms import height_map

PARAMS = height_map(Profile(body=Body(height_m=2.3)))
FAR_AWAY = Building(((300.0, -5.0), (300.0, 5.0), (310.0, 0.0)), 9.0)


def a_scan(
    boxes: list[tuple[float, float, float, float]], slope: float = 0.0, noise_m: float = 0.02
) -> np.ndarray:
    """One VLP-16 turn over sloping ground with boxes (x, y, side, height), by ray and slab, base frame."""
    rng = np.random.default_rng(3)
    elevation = np.radians(np.repeat(np.arange(-15.0, 16.0, 2.0), 1800))
    azimuth = np.tile(np.arange(1800) * math.tau / 1800, 16)
    rays = np.column_stack(
        (np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation))
    )
    origin = np.array([3.2, 0.0, 2.28])
    with np.errstate(divide="ignore", invalid="ignore"):
        down = rays[:, 2] - slope * rays[:, 0]
        ranges = np.where(down < 0.0, (slope * origin[0] - origin[2]) / down, np.inf)
        for x, y, side, height in boxes:
            low = np.array([x - side / 2, y - side / 2, slope * x])
            high = np.array([x + side / 2, y + side / 2, slope * x + height])
            near, far = (low - origin) / rays, (high - origin) / rays
            enter = np.nanmax(np.minimum(near, far), axis=1)
            leave = np.nanmin(np.maximum(near, far), axis=1)
            ranges = np.where((enter < leave) & (enter > 0.0), np.minimum(ranges, enter), ranges)
    seen = np.isfinite(ranges) & (ranges < 100.0)
    ranges = ranges[seen] + noise_m * rng.standard_normal(int(seen.sum()))
    points: np.ndarray = (origin + rays[seen] * ranges[:, None]).astype(np.float32)
    return points


@pytest.mark.parametrize("distance_m", [5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0])
@pytest.mark.parametrize("bearing_rad", [0.0, 0.3])
def test_a_person_is_found_where_he_stands(distance_m: float, bearing_rad: float) -> None:
    x = 3.5 + distance_m * math.cos(bearing_rad)
    y = distance_m * math.sin(bearing_rad)
    percept = percept_from_scan(a_scan([(x, y, 0.5, 1.7)]), 1, PARAMS)
    away = np.hypot(percept.cells_base[:, 0] - x, percept.cells_base[:, 1] - y)
    assert len(away) > 0
    assert away.max() < 0.6, "nothing but the person"


@pytest.mark.parametrize("slope", [0.0, 0.05, -0.05, 0.12, -0.12])
def test_ground_is_no_obstacle_level_or_sloping(slope: float) -> None:
    percept = percept_from_scan(a_scan([], slope), 1, PARAMS)
    assert percept.points_used > 1000
    assert len(percept.cells_base) == 0


@pytest.mark.parametrize(
    ("slope", "distance_m"), [(0.12, 8.0), (0.12, 14.0), (0.12, 18.0), (-0.12, 14.0), (-0.12, 18.0)]
)
def test_a_person_is_found_on_a_steep_road(slope: float, distance_m: float) -> None:
    x = 3.5 + distance_m
    percept = percept_from_scan(a_scan([(x, 0.0, 0.5, 1.7)], slope), 1, PARAMS)
    away = np.hypot(percept.cells_base[:, 0] - x, percept.cells_base[:, 1])
    assert len(away) > 0
    assert away.max() < 0.6, "nothing but the person"


def test_a_branch_over_a_road_that_leads_down_is_above_the_shuttle() -> None:
    road = [[15.0 + 0.3 * k, 0.0, -0.1 * (15.0 + 0.3 * k)] for k in range(8)]
    branch = [[16.0, 0.0, 1.2], [16.1, 0.0, 1.5]]
    assert percept_from_scan(np.array(road + branch, np.float32), 1, PARAMS).points_used == len(road)


def a_step(height_m: float, on_top: tuple[float, ...] = ()) -> np.ndarray:
    """A kerb along x at y = 2.1 with pavement behind it, and what stands on it at x = 8.1."""
    xs = np.arange(7.0, 9.0, 0.05)
    parts = [np.column_stack((xs, np.full(len(xs), 2.05), np.zeros(len(xs))))]
    parts += [np.column_stack((xs, np.full(len(xs), y), np.full(len(xs), height_m))) for y in (2.12, 2.4)]
    parts.append(np.array([[8.1, 2.2, z] for z in on_top]).reshape(-1, 3))
    step: np.ndarray = np.vstack(parts).astype(np.float32)
    return step


def test_a_kerb_is_a_low_obstacle_and_what_stands_on_it_is_none() -> None:
    kerb = percept_from_scan(a_step(0.12), 1, PARAMS)
    assert len(kerb.cells_base) >= 7
    assert kerb.is_low.all()
    post = percept_from_scan(a_step(0.12, (0.5, 0.9)), 1, PARAMS)
    near = np.abs(post.cells_base[:, 0] - 8.1) < 0.3
    assert not post.is_low[near].any()
    assert post.is_low[~near].any()


@pytest.mark.parametrize(("height_m", "is_low"), [(0.08, True), (0.17, True), (0.2, False), (0.3, False)])
def test_only_steps_that_a_body_passes_over_are_kerbs(height_m: float, is_low: bool) -> None:
    percept = percept_from_scan(a_step(height_m), 1, PARAMS)
    assert len(percept.cells_base)
    assert bool(percept.is_low.all()) == is_low


def test_what_is_above_the_shuttle_does_not_count() -> None:
    roof = np.array([[8.0, 0.0, 2.5], [8.0, 0.0, 3.0], [8.1, 0.1, 2.9]], dtype=np.float32)
    percept = percept_from_scan(roof, 1, PARAMS)
    assert percept.points_used == 0


def test_the_own_body_is_left_out() -> None:
    body = np.array([[x, 0.7, z] for x in (0.0, 1.0, 3.4) for z in (0.3, 1.5)], dtype=np.float32)
    assert percept_from_scan(body, 1, PARAMS).points_used == 0


def test_a_single_return_is_no_obstacle() -> None:
    lone = np.array([[8.0, 0.0, 1.0]], dtype=np.float32)
    assert len(percept_from_scan(lone, 1, PARAMS).cells_base) == 0


def test_two_returns_of_different_height_make_a_cell_where_they_are() -> None:
    pair = np.array([[8.05, 0.05, 0.5], [8.1, 0.1, 1.0]], dtype=np.float32)
    percept = percept_from_scan(pair, 1, PARAMS)
    assert percept.points_used == 2
    assert percept.cells_base.tolist() == [[8.125, 0.125]]
    assert percept.heights_m.tolist() == [0.5]


def test_returns_that_do_not_count_hide_none_that_come_after_them() -> None:
    left_out = [[90.0, 0.0, 1.0], [8.0, 0.0, -5.0], [1.0, 0.0, 1.0]]
    empty_cell_first = [[4.0, -3.0, 1.0]]
    pair = [[8.05, 0.05, 0.5], [8.1, 0.1, 1.0]]
    percept = percept_from_scan(np.array(left_out + empty_cell_first + pair, np.float32), 1, PARAMS)
    assert percept.cells_base.tolist() == [[8.125, 0.125]]
    assert percept.points_used == 3


def test_two_returns_of_one_ring_make_a_cell_where_the_ground_around_them_is_seen() -> None:
    ring = [[8.05, 0.05, 0.6], [8.1, 0.1, 0.6]]
    ground = [[9.0, 0.5, 0.0]]
    assert len(percept_from_scan(np.array(ring, np.float32), 1, PARAMS).cells_base) == 0
    percept = percept_from_scan(np.array(ring + ground, np.float32), 1, PARAMS)
    assert percept.cells_base.tolist() == [[8.125, 0.125]]
    assert percept.heights_m.tolist() == [pytest.approx(0.6)]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_ground_counts_as_near_within_two_metres_and_not_beyond_four(side: float) -> None:
    """Ground levels are kept in squares of two metres; those next to a return's own square count."""
    for low_x_m, counts in ((12.5 + side * 2.0, True), (12.5 + side * 4.6, False)):
        ring = [[12.05, 0.05, 0.6], [12.1, 0.1, 0.6], [low_x_m, 0.05, 0.0], [low_x_m, 0.1, 0.0]]
        cells = percept_from_scan(np.array(ring, np.float32), 1, PARAMS).cells_base
        assert len(cells) == counts, low_x_m


def test_ground_at_one_edge_of_the_map_is_no_ground_at_the_other() -> None:
    for x_m, over_there_m in ((12.0, 14.0), (12.0, 10.0), (-11.0, -9.0), (34.0, 32.0)):
        for side in (1.0, -1.0):
            ring = [[x_m + 0.05, side * 14.05, 0.6], [x_m + 0.1, side * 14.1, 0.6]]
            ground = [[over_there_m, -side * 14.0, 0.0], [over_there_m, -side * 14.1, 0.0]]
            cells = percept_from_scan(np.array(ring + ground, np.float32), 1, PARAMS).cells_base
            assert len(cells) == 0, (x_m, side)


@pytest.mark.parametrize(("x_m", "y_m"), [(34.8, 0.0), (-11.8, 0.0), (8.0, 14.8), (8.0, -14.8)])
def test_ground_beside_a_return_counts_at_the_edges_of_the_map_too(x_m: float, y_m: float) -> None:
    inward = (x_m - math.copysign(0.8, x_m), y_m) if y_m == 0.0 else (x_m, y_m - math.copysign(0.8, y_m))
    ring = [[x_m, y_m, 0.6], [x_m + 0.02, y_m, 0.6]]
    cells = percept_from_scan(np.array([*ring, [*inward, 0.0]], np.float32), 1, PARAMS).cells_base
    assert len(cells) == 1


def test_a_map_that_is_no_whole_number_of_ground_squares_wide_keeps_its_edges_apart() -> None:
    wide = PARAMS._replace(reach_side_m=15.2)
    for x_m, over_there_m in ((12.0, 14.0), (12.0, 10.0)):
        ring = [[x_m + 0.05, 15.1, 0.6], [x_m + 0.1, 15.1, 0.6]]
        over_there = [[over_there_m, -15.1, 0.0], [over_there_m, -15.0, 0.0]]
        beside = [[x_m, 14.0, 0.0]]
        assert len(percept_from_scan(np.array(ring + over_there, np.float32), 1, wide).cells_base) == 0
        assert len(percept_from_scan(np.array(ring + beside, np.float32), 1, wide).cells_base) == 1


def test_the_map_ends_where_it_should_and_what_is_just_inside_counts() -> None:
    def used(*places: tuple[float, float, float]) -> int:
        return percept_from_scan(np.array(places, np.float32), 1, PARAMS).points_used

    assert used((34.9, 0.0, 0.5), (-11.9, 0.0, 0.5), (8.0, 14.9, 0.5), (8.0, -14.9, 0.5)) == 4
    assert used((35.1, 0.0, 0.5), (-12.1, 0.0, 0.5), (8.0, 15.1, 0.5), (8.0, -15.1, 0.5)) == 0
    assert used((5.0, 0.0, 2.39)) == used((5.0, 0.0, -0.99)) == 1
    assert used((5.0, 0.0, 2.41)) == used((5.0, 0.0, -1.01)) == 0
    assert used((3.55, 0.0, 0.5), (-0.9, 0.0, 0.5), (1.0, 0.9, 0.5), (1.0, -0.9, 0.5)) == 0, "the body"
    assert used((3.65, 0.0, 0.5), (-1.0, 0.0, 0.5), (1.0, 0.93, 0.5), (1.0, -0.93, 0.5)) == 4


def test_an_empty_scan_says_that_the_sensor_is_blind() -> None:
    percept = percept_from_scan(np.empty((0, 3), np.float32), 7, PARAMS)
    assert (percept.points_used, percept.stamp_ns, len(percept.cells_base)) == (0, 7, 0)


def test_a_scan_of_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match=r"\(n, 3\)"):
        percept_from_scan(np.zeros((4, 4), np.float32), 1, PARAMS)


def test_the_simulated_lidar_shows_a_pedestrian_too() -> None:
    lidar = Lidar(LidarMount(), Body(), WallScene((FAR_AWAY,)), LidarNoise())
    people = np.array([[15.0, 0.5, 0.25, 1.7]])
    scan = lidar.scan(Pose2(0.0, 0.0, 0.0), np.empty((0, 7)), people, np.random.default_rng(2))
    cells = percept_from_scan(scan[0], 1, PARAMS).cells_base
    assert np.min(np.hypot(cells[:, 0] - 15.0, cells[:, 1] - 0.5)) < 0.4
    assert np.max(np.hypot(cells[:, 0] - 15.0, cells[:, 1] - 0.5)) < 0.8


@pytest.mark.parametrize(("difference_m", "occupied"), [(0.069, False), (0.071, True)])
def test_returns_that_differ_by_more_than_seven_centimetres_are_an_obstacle(
    difference_m: float, occupied: bool
) -> None:
    """GEM, section V."""
    pair = np.array([[8.05, 0.05, 0.5], [8.1, 0.1, 0.5 + difference_m]], dtype=np.float32)
    assert bool(len(percept_from_scan(pair, 1, PARAMS).cells_base)) == occupied


@pytest.mark.parametrize(("above_ground_m", "occupied"), [(0.34, False), (0.36, True)])
def test_returns_of_one_ring_are_an_obstacle_from_a_step_above_the_ground(
    above_ground_m: float, occupied: bool
) -> None:
    z = -0.2 + above_ground_m
    ring = [[8.05, 0.05, z], [8.1, 0.1, z], [9.0, 0.5, -0.2]]
    assert bool(len(percept_from_scan(np.array(ring, np.float32), 1, PARAMS).cells_base)) == occupied
