"""The shipped detector finds road users in a street that it never saw, and takes bad files and odd scans."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.vehicle_agent.perception.pillars import street_scan
from vehicle_agent.perception.pillars.detector import PillarDetector
from vehicle_agent.perception.pillars.detector_file import (
    DEFAULT_DETECTOR,
    DetectorFileError,
    read_detector_file,
    record_path,
)
from vehicle_agent.perception.pillars.sweeps import OlderTurn, Sweep, step
from vehicle_agent.signals import TRACK_KINDS
from vehicle_agent.signals.objects import SeenObjects


@pytest.fixture(scope="module")
def detector() -> PillarDetector:
    return PillarDetector()


@pytest.fixture(scope="module")
def sweeps() -> tuple[Sweep, Sweep]:
    return street_scan.turns(street_scan.street())


@pytest.fixture(scope="module")
def seen(detector: PillarDetector, sweeps: tuple[Sweep, Sweep]) -> SeenObjects:
    older, _ = step((sweeps[0],), sweeps[1])
    return detector.seen(sweeps[1].points_base, sweeps[1].intensities, sweeps[1].stamp_ns, older)


def nearest(seen: SeenObjects, number: int) -> int:
    apart = np.hypot(*(seen.poses_base[:, :2] - street_scan.POSES[number, :2]).T)
    return int(np.argmin(apart))


@pytest.mark.parametrize("number", range(4), ids=["person", "cyclist", "oncoming car", "car behind"])
def test_each_road_user_is_found_where_it_is(seen: SeenObjects, number: int) -> None:
    row = nearest(seen, number)
    assert TRACK_KINDS[seen.kinds[row]] == TRACK_KINDS[street_scan.KINDS[number]]
    assert np.hypot(*(seen.poses_base[row, :2] - street_scan.POSES[number, :2])) < 0.5
    assert seen.sizes_m[row, :2] == pytest.approx(street_scan.SIZES_M[number], rel=0.35)
    assert seen.velocities_base_mps[row] == pytest.approx(street_scan.velocities_mps()[number], abs=0.7)
    # A standing vehicle may be taken for one that faces the other way.
    off = seen.poses_base[row, 2] - street_scan.POSES[number, 2]
    assert abs(np.cos(off)) > 0.9


def test_a_street_with_four_road_users_does_not_show_many_more(seen: SeenObjects) -> None:
    assert np.count_nonzero(seen.scores > 0.4) <= 6


def test_the_same_scan_gives_the_same_objects(
    detector: PillarDetector, sweeps: tuple[Sweep, Sweep], seen: SeenObjects
) -> None:
    older, _ = step((sweeps[0],), sweeps[1])
    again = detector.seen(sweeps[1].points_base, sweeps[1].intensities, sweeps[1].stamp_ns, older)
    assert (again.poses_base == seen.poses_base).all()
    assert (again.scores == seen.scores).all()


def test_without_an_older_turn_there_are_objects_and_no_velocities(
    detector: PillarDetector, sweeps: tuple[Sweep, Sweep]
) -> None:
    seen = detector.seen(sweeps[1].points_base, sweeps[1].intensities, 7)
    assert seen.stamp_ns == 7
    assert len(seen.kinds) >= 3
    assert np.isnan(seen.velocities_base_mps).all()


@pytest.mark.parametrize(
    "points",
    [
        np.empty((0, 3), dtype=np.float32),
        np.full((50, 3), np.nan, dtype=np.float32),
        np.full((50, 3), 1e6, dtype=np.float32),
        np.tile(np.array([[8.0, 1.0, 0.9]], dtype=np.float32), (5_000, 1)),
    ],
    ids=["empty", "no numbers", "far away", "one place"],
)
def test_odd_scans_give_no_road_users(detector: PillarDetector, points: np.ndarray) -> None:
    seen = detector.seen(points, np.full(len(points), 20.0, dtype=np.float32), 1)
    assert np.isfinite(seen.poses_base).all()
    assert len(seen.kinds) <= 1


def test_300_people_are_a_scan_like_any_other(detector: PillarDetector) -> None:
    rng = np.random.default_rng(1)
    places = np.array([(x, y) for x in range(-15, 39, 3) for y in range(-18, 19, 2)], dtype=float)[:300]
    around = rng.normal(0.0, 0.12, (300, 40, 3))
    around[:, :, 2] = rng.uniform(0.3, 1.7, (300, 40))
    around[:, :, :2] += places[:, None]
    points = around.reshape(-1, 3).astype(np.float32)
    intensities = np.full(len(points), 30.0, dtype=np.float32)
    seen = detector.seen(points, intensities, 1, OlderTurn(points, intensities, 0.2))
    assert 150 <= len(seen.kinds) <= 400


def test_other_shapes_are_refused(detector: PillarDetector) -> None:
    with pytest.raises(ValueError, match="intensities"):
        detector.seen(np.zeros((4, 3), dtype=np.float32), np.zeros(3, dtype=np.float32), 1)
    with pytest.raises(ValueError, match=r"\(n, 3\)"):
        detector.seen(np.zeros((4, 4), dtype=np.float32), np.zeros(4, dtype=np.float32), 1)


def copied(folder: Path) -> Path:
    for path in (DEFAULT_DETECTOR, record_path(DEFAULT_DETECTOR)):
        shutil.copy(path, folder)
    return folder / DEFAULT_DETECTOR.name


def test_a_file_of_another_version_is_refused_with_both_versions(tmp_path: Path) -> None:
    path = copied(tmp_path)
    record = json.loads(record_path(path).read_text())
    record_path(path).write_text(json.dumps(record | {"version": 99}))
    with pytest.raises(DetectorFileError, match="version 99, and this program runs 1"):
        PillarDetector(path)


def test_a_changed_missing_or_foreign_file_is_refused(tmp_path: Path) -> None:
    path = copied(tmp_path)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(DetectorFileError, match="broken or changed"):
        PillarDetector(path)
    record_path(path).write_text("{}")
    with pytest.raises(DetectorFileError, match="no detector's record"):
        PillarDetector(path)
    path.unlink()
    with pytest.raises(DetectorFileError, match="cannot be read"):
        PillarDetector(path)


def test_the_shipped_detector_names_its_training_and_licence() -> None:
    model, record = read_detector_file(DEFAULT_DETECTOR)
    assert len(model) < 3_000_000
    assert record.license == "Apache-2.0"
    assert record.train_cpu_min <= 60.0
    assert len(record.losses) == record.epochs
    assert (DEFAULT_DETECTOR.parent / "LICENSE.md").read_text().startswith("# ")
