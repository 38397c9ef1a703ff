"""Whatever is done to a scan at random, its boxes still hold their returns and move with them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.workshop.detector.scans import a_scan
from vehicle_agent.perception.pillars.grid import PillarGrid
from workshop.detector.batches import batch_of, varied, window
from workshop.detector.labeled_scans import LabeledScan


def inside(scan: LabeledScan, box: np.ndarray, moved_s: float, is_older: bool) -> int:
    points = scan.points[scan.is_older == is_older]
    apart = points[:, :2] - (box[:2] - moved_s * box[6:8])
    along = np.cos(box[2]) * apart[:, 0] + np.sin(box[2]) * apart[:, 1]
    across = -np.sin(box[2]) * apart[:, 0] + np.cos(box[2]) * apart[:, 1]
    within = (np.abs(along) < 0.5 * box[3] + 0.02) & (np.abs(across) < 0.5 * box[4] + 0.02)
    return int((within & (points[:, 2] < box[5] + 0.2)).sum())


@given(seed=st.integers(0, 10_000))
@settings(max_examples=50)
def test_boxes_hold_their_returns_in_both_turns(seed: int) -> None:
    plain = a_scan(seed)
    scan = varied(plain, np.random.default_rng(seed))
    share = len(scan.points) / len(plain.points)
    for box in scan.boxes:
        assert inside(scan, box, 0.0, False) >= 0.5 * share * 60
        assert inside(scan, box, scan.older_s, True) >= 0.5 * share * 60


@given(seed=st.integers(0, 10_000))
@settings(max_examples=30)
def test_a_window_is_of_one_size_and_within_reach(seed: int) -> None:
    part = window(a_scan(seed), PillarGrid(), np.random.default_rng(seed))
    assert (part.nx % 8, part.ny % 8) == (0, 0)
    assert part.x_m_min >= -44.001
    assert part.x_m_max <= 44.001
    assert part.y_m_max <= 44.001


def test_scans_of_a_batch_have_squares_of_their_own() -> None:
    grid = PillarGrid()
    batch = batch_of([a_scan(1), a_scan(2)], grid)
    alone = batch_of([a_scan(2)], grid)
    squares = 2 * grid.nx * grid.ny
    second = batch.cells >= squares
    assert (batch.cells[second] - squares).tolist() == alone.cells.tolist()
    assert (batch.features[second] == alone.features).all()
    assert (batch.targets.heat[1] == alone.targets.heat[0]).all()


def test_objects_with_few_returns_are_neither_wanted_nor_wrong() -> None:
    scan = a_scan(3)._replace(hits=np.zeros(6, dtype=np.int64))
    targets = batch_of([scan], PillarGrid()).targets
    assert targets.heat.max() == 0.0
    assert targets.heat_weight.min() == 0.0
    assert targets.box_weight.max() == 0.0
