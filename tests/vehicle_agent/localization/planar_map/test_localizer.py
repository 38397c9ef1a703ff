"""The worker finds the vehicle in its map, keeps it where things hide the walls, and finds it again."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Array, Pose2, compose, inverse, wrap_angle
from contract.occupancy.occupancy_map import FREE, OCCUPIED, Cells
from vehicle_agent.localization.planar_map.field_window import OccupancyTiles
from vehicle_agent.localization.planar_map.matcher import PlanarMatcher, laser_scan
from vehicle_agent.signals import LocalizationJob, ScanAnswer, ScanPose, ScanUnplaced
from vehicle_agent.signals.point_cloud import point_cloud

TILE_M, CELL_M = 32.0, 0.1
LASER = Pose2(1.9, 0.0, 0.0)
STEP_RAD = math.radians(0.5)
# Boxes (x0, y0, x1, y1) in a yard of one tile, no two alike.
BOXES = ((4.0, 5.0, 7.0, 6.5), (22.0, 4.0, 24.0, 9.0), (25.0, 24.0, 29.0, 26.0), (6.0, 22.0, 8.0, 27.0),
         (14.0, 28.0, 17.0, 30.0), (12.0, 2.0, 13.0, 4.0))  # fmt: skip
ODOM = Pose2(3.0, -2.0, 0.7)
TRUE = Pose2(0.0, 0.0, 0.0)


def yard() -> Cells:
    side = round(TILE_M / CELL_M)
    cells: Cells = np.full((side, side), FREE, dtype=np.uint8)
    cells[:3, :] = cells[-3:, :] = cells[:, :3] = cells[:, -3:] = OCCUPIED
    for x0, y0, x1, y1 in BOXES:
        cells[round(y0 / CELL_M) : round(y1 / CELL_M), round(x0 / CELL_M) : round(x1 / CELL_M)] = OCCUPIED
    return cells


YARD = yard()
TILES = OccupancyTiles(lambda ix, iy: YARD if (ix, iy) == (0, 0) else None, TILE_M, CELL_M, ((0, 0),))


def seen_from(
    pose: Pose2,
    rng: np.random.Generator,
    hidden_rad: tuple[float, float] = (9.0, 9.0),
    cells: Cells | None = None,
) -> Array:
    """(n, 3) points of a scan, base frame. hidden_rad: between these directions a truck stands 4 m away."""
    laser = compose(pose, LASER)
    angles = np.arange(-0.75 * math.pi, 0.75 * math.pi, STEP_RAD)
    ranges = np.zeros(len(angles))
    for number, angle in enumerate(angles):
        if hidden_rad[0] < angle < hidden_rad[1]:
            ranges[number] = 4.0
            continue
        cos, sin = math.cos(laser.yaw_rad + angle), math.sin(laser.yaw_rad + angle)
        reach = np.arange(0.5, 45.0, 0.05)
        columns = np.floor((laser.x_m + cos * reach) / CELL_M).astype(int)
        rows = np.floor((laser.y_m + sin * reach) / CELL_M).astype(int)
        yard = YARD if cells is None else cells
        hit = yard[np.clip(rows, 0, len(yard) - 1), np.clip(columns, 0, len(yard) - 1)] == OCCUPIED
        ranges[number] = reach[np.argmax(hit)]
    ranges += 0.01 * rng.standard_normal(len(ranges))
    return np.column_stack(
        (LASER.x_m + ranges * np.cos(angles), ranges * np.sin(angles), np.full(len(angles), 1.9))
    )


class Drive:
    """A vehicle that drives straight on through the yard at 2 m/s, and its worker."""

    def __init__(self, start: Pose2, seed: int = 1) -> None:
        self.pose, self.rng, self.number = start, np.random.default_rng(seed), 0
        self.carried = TRUE
        self.matcher = PlanarMatcher(TILES, LASER, STEP_RAD, seed)

    def answer(
        self,
        off: Pose2,
        std_m: float,
        hidden_rad: tuple[float, float] = (9.0, 9.0),
        way_m: float = 0.2,
        is_unknown: bool = False,
    ) -> ScanAnswer:
        """To the next scan, when the room believes the vehicle to be `off` from where it is."""
        self.number += 1
        self.pose = compose(self.pose, Pose2(way_m, 0.0, 0.0))
        stamp_ns = 100_000_000 * self.number
        covariance = np.diag([std_m**2, std_m**2, 1e-4])
        believed = Pose2(
            self.pose.x_m + off.x_m, self.pose.y_m + off.y_m, wrap_angle(self.pose.yaw_rad + off.yaw_rad)
        )
        job = LocalizationJob(
            stamp_ns,
            believed,
            compose(ODOM, compose(inverse(self.carried), self.pose)),
            covariance,
            2.0,
            0.0,
            False,
            is_unknown,
        )
        return self.matcher.step(point_cloud(stamp_ns, seen_from(self.pose, self.rng, hidden_rad)), job)

    def off_m(self, answer: ScanAnswer) -> float:
        assert isinstance(answer, ScanPose)
        return math.hypot(answer.pose_map.x_m - self.pose.x_m, answer.pose_map.y_m - self.pose.y_m)


def test_a_vehicle_that_is_30_cm_off_is_put_right() -> None:
    drive = Drive(Pose2(9.0, 12.0, 0.3))
    for _ in range(10):
        answer = drive.answer(Pose2(0.3, -0.1, 0.0), 0.3)
    assert drive.off_m(answer) < 0.06
    assert isinstance(answer, ScanPose)
    assert answer.agreement > 0.9


def test_a_prior_of_metres_is_searched() -> None:
    drive = Drive(Pose2(9.0, 12.0, 0.3))
    for _ in range(8):
        answer = drive.answer(Pose2(3.0, -2.0, 0.2), 3.0)
    assert drive.off_m(answer) < 0.1


def test_a_truck_that_hides_half_of_the_walls_neither_moves_the_pose_nor_casts_doubt() -> None:
    drive = Drive(Pose2(8.0, 12.0, 0.2))
    for _ in range(30):
        answer = drive.answer(TRUE, 0.1, hidden_rad=(-1.2, 1.2))
        assert drive.off_m(answer) < 0.15
    assert isinstance(answer, ScanPose)
    assert answer.agreement > 0.6


def test_a_kidnapped_vehicle_is_doubted_and_found_again() -> None:
    drive = Drive(Pose2(9.0, 12.0, 0.3))
    for _ in range(10):
        drive.answer(TRUE, 0.05)
    # It is carried away: neither wheels nor gyroscope notice.
    before = drive.pose
    drive.pose = compose(before, Pose2(5.0, 3.0, 0.25))
    drive.carried = compose(drive.pose, inverse(before))
    off = Pose2(before.x_m - drive.pose.x_m, before.y_m - drive.pose.y_m, -0.25)
    answers: list[ScanAnswer] = []
    for _ in range(60):
        # The room follows when scans in a row say the same other place.
        found = [answer for answer in answers[-8:] if isinstance(answer, ScanPose) and answer.is_searched]
        off = TRUE if len(found) == 8 else off
        answers.append(drive.answer(off, 0.05, way_m=0.0))
    doubts = [answer.agreement for answer in answers if isinstance(answer, ScanPose)]
    assert min(doubts) < 0.4
    assert drive.off_m(answers[-1]) < 0.15
    assert isinstance(answers[-1], ScanPose)
    assert answers[-1].agreement > 0.85


def test_a_vehicle_of_which_nothing_is_known_is_found_in_the_whole_map() -> None:
    drive = Drive(Pose2(9.0, 12.0, 2.3))
    answers = [drive.answer(TRUE, 0.0, way_m=0.0, is_unknown=True) for _ in range(12)]
    assert answers[0] == ScanUnplaced(100_000_000, "searching")
    assert drive.off_m(answers[-1]) < 0.1
    assert isinstance(answers[-1], ScanPose)
    assert answers[-1].agreement > 0.8


def test_a_search_says_no_place_where_two_look_alike() -> None:
    """A bare square yard looks the same from four corners."""
    side = round(TILE_M / CELL_M)
    bare: Cells = np.full((side, side), FREE, dtype=np.uint8)
    bare[:3, :] = bare[-3:, :] = bare[:, :3] = bare[:, -3:] = OCCUPIED
    tiles = OccupancyTiles(lambda ix, iy: bare if (ix, iy) == (0, 0) else None, TILE_M, CELL_M, ((0, 0),))
    matcher = PlanarMatcher(tiles, LASER, STEP_RAD, 1)
    pose, rng = Pose2(9.0, 12.0, 0.3), np.random.default_rng(2)
    points = seen_from(pose, rng, cells=bare)
    for number in range(1, 15):
        job = LocalizationJob(number, TRUE, ODOM, np.eye(3), 0.0, 0.0, False, True)
        assert matcher.step(point_cloud(number, points), job) == ScanUnplaced(number, "searching")


def test_where_the_map_has_nothing_the_worker_says_so() -> None:
    drive = Drive(Pose2(9.0, 12.0, 0.3))
    assert drive.answer(Pose2(500.0, 500.0, 0.0), 0.1) == ScanUnplaced(100_000_000, "no_map")


def test_an_empty_scan_says_too_little() -> None:
    matcher = PlanarMatcher(TILES, LASER, STEP_RAD, 1)
    pose = Pose2(9.0, 12.0, 0.3)
    job = LocalizationJob(7, pose, pose, 0.01 * np.eye(3), 0.0, 0.0)
    for points in (np.zeros((0, 3)), np.full((50, 3), np.nan)):
        assert matcher.step(point_cloud(7, points), job) == ScanUnplaced(7, "too_little")


def test_equal_drives_get_equal_answers() -> None:
    first, second = Drive(Pose2(9.0, 12.0, 0.3), seed=3), Drive(Pose2(9.0, 12.0, 0.3), seed=3)
    for _ in range(5):
        one, other = first.answer(TRUE, 0.2), second.answer(TRUE, 0.2)
        assert isinstance(one, ScanPose)
        assert isinstance(other, ScanPose)
        assert one.pose_map == other.pose_map
        assert np.array_equal(one.covariance, other.covariance)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(0.6, 40.0), st.integers(-300, 300)), unique_by=lambda pair: pair[1], max_size=80
    )
)
def test_a_scan_has_the_points_of_its_cloud(beams: list[tuple[float, int]]) -> None:
    points = np.array(
        [
            (LASER.x_m + reach * math.cos(k * STEP_RAD), reach * math.sin(k * STEP_RAD), 1.9)
            for reach, k in beams
        ]
    ).reshape(-1, 3)
    scan = laser_scan(1, points, LASER, STEP_RAD)
    seen = np.isfinite(scan.ranges_m)
    assert seen.sum() == len(beams)
    back = np.column_stack(
        (
            LASER.x_m + scan.ranges_m[seen] * np.cos(scan.angles_rad[seen]),
            scan.ranges_m[seen] * np.sin(scan.angles_rad[seen]),
        )
    )
    in_order = points[np.argsort([k for _, k in beams])].reshape(-1, 3)
    assert back == pytest.approx(in_order[:, :2], abs=1e-9)
    assert (np.diff(scan.angles_rad) > 0.0).all()
