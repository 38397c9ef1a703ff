"""Maps from simulated logs whose walls and poses are known, and from logs that show nothing."""

import csv
import json
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from contract.geometry import Pose2
from contract.occupancy.map_files import read_map
from contract.occupancy.occupancy_map import FREE, OCCUPIED, UNKNOWN
from tests.workshop.simulated_drive import WALLS, SimulatedDrive, drive, write_carmen
from vehicle_agent.localization.laser.pose_arrays import between, composed
from workshop.carmen.beams import Beams
from workshop.carmen.laser_logs import LaserLog, read_laser_log
from workshop.laser_mapping.map_folder import write_map_folder
from workshop.laser_mapping.mapping import LaserMap, MappingParams, NoProgress, map_log
from workshop.laser_mapping.occupancy import MapTooLarge, OccupancyParams, occupancy_map

PARAMS = MappingParams()


def mapped(log: LaserLog) -> LaserMap:
    return map_log(log, PARAMS, NoProgress())


@pytest.fixture(scope="module")
def driven() -> SimulatedDrive:
    return drive(rounds=1.4)


@pytest.fixture(scope="module")
def laser_map(driven: SimulatedDrive) -> LaserMap:
    return mapped(driven.log)


def test_relative_poses_are_right_within_three_centimetres(
    driven: SimulatedDrive, laser_map: LaserMap
) -> None:
    for gap in (5, 100, len(driven.truth) - 20):
        error = between(
            between(driven.truth[:-gap], driven.truth[gap:]),
            between(laser_map.poses[:-gap], laser_map.poses[gap:]),
        )
        assert np.hypot(error[:, 0], error[:, 1]).mean() < 0.03
        assert np.degrees(np.abs(error[:, 2])).mean() < 0.3


def test_loops_are_closed_and_passes_agree(laser_map: LaserMap) -> None:
    numbers = laser_map.residuals
    assert numbers.loops_closed >= 10
    assert numbers.passes >= 20
    assert numbers.pass_p95_m < 0.03
    assert numbers.scans == len(laser_map.poses)


def test_walls_are_where_they_are_and_the_way_is_free(driven: SimulatedDrive, laser_map: LaserMap) -> None:
    T_map_world = composed(laser_map.poses[0], between(driven.truth[0], np.zeros(3)))
    seen, wrong = 0, 0
    for x0, y0, x1, y1 in WALLS[:4]:
        for share in np.linspace(0.1, 0.9, 40):
            x_m, y_m, _ = composed(
                T_map_world, np.array([x0 + share * (x1 - x0), y0 + share * (y1 - y0), 0.0])
            )
            around = [
                laser_map.occupancy.state_at(x_m + dx, y_m + dy)
                for dx in (-0.05, 0, 0.05)
                for dy in (-0.05, 0, 0.05)
            ]
            seen += OCCUPIED in around
            wrong += OCCUPIED not in around and FREE in around
    assert seen > 100
    assert wrong < 25
    assert all(laser_map.occupancy.state_at(x, y) == FREE for x, y, _ in laser_map.poses)
    block = composed(T_map_world, np.array([10.0, 7.0, 0.0]))
    assert laser_map.occupancy.state_at(block[0], block[1]) == UNKNOWN


def test_equal_logs_give_equal_maps(driven: SimulatedDrive) -> None:
    short = msgspec.structs.replace(
        driven.log,
        ranges_m=driven.log.ranges_m[:60],
        stamps_s=driven.log.stamps_s[:60],
        odometry=driven.log.odometry[:60],
    )
    first, second = mapped(short), mapped(short)
    assert first.occupancy.map_hash == second.occupancy.map_hash
    assert (first.poses == second.poses).all()


def test_a_beam_frees_the_cells_before_its_end_and_occupies_its_end() -> None:
    log = LaserLog(
        Beams(0.0, math.pi / 2, 2),
        np.array([[1.0, np.nan]]),
        np.zeros(1),
        np.zeros((1, 3)),
        Pose2(0.0, 0.0, 0.0),
        (),
    )
    params = OccupancyParams(cell_m=0.1, hits_min=1, passes_min=1)
    found = occupancy_map(log, np.array([[0.05, 0.25, 0.0]]), params, lambda steps: None)
    assert [found.state_at(0.05 + 0.1 * i, 0.25) for i in range(13)] == [FREE] * 10 + [
        OCCUPIED,
        UNKNOWN,
        UNKNOWN,
    ]
    assert found.state_at(0.5, 0.35) == UNKNOWN
    assert (found.cells == OCCUPIED).sum() == 1


def test_a_map_that_does_not_fit_is_refused() -> None:
    log = LaserLog(
        Beams(0.0, 0.1, 2), np.ones((2, 2)), np.zeros(2), np.zeros((2, 3)), Pose2(0.0, 0.0, 0.0), ()
    )
    with pytest.raises(MapTooLarge):
        occupancy_map(log, np.array([[0.0, 0, 0], [9e4, 9e4, 0]]), OccupancyParams(), lambda steps: None)


@pytest.mark.parametrize("count", [1, 2, 30])
def test_scans_that_see_nothing_give_a_map_of_nothing(count: int) -> None:
    way = np.stack([0.3 * np.arange(count), np.zeros(count), np.zeros(count)], axis=1)
    log = LaserLog(
        Beams.of_front_laser(181),
        np.full((count, 181), np.nan),
        np.arange(count) * 0.2,
        way,
        Pose2(0.0, 0.0, 0.0),
        (),
    )
    found = mapped(log)
    assert found.poses == pytest.approx(way, abs=1e-6)
    assert (found.occupancy.cells == UNKNOWN).all()
    assert found.residuals.loops_closed == 0


def test_the_folder_has_what_the_map_says(tmp_path: Path) -> None:
    driven = drive(rounds=0.15, beams=Beams.of_front_laser(180))
    path = tmp_path / "log.clf"
    write_carmen(driven.log, path)
    log = read_laser_log(path)
    found = mapped(log)
    written = write_map_folder(tmp_path / "out", found, log, path.name)
    assert [file.name for file in written] == ["map.yaml", "trajectory.csv", "report.json", "picture.png"]
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert read_map(tmp_path / "out" / "map.yaml").map_hash == report["map_hash"] == found.occupancy.map_hash
    rows = list(csv.DictReader((tmp_path / "out" / "trajectory.csv").open()))
    assert [float(row["stamp_s"]) for row in rows] == pytest.approx(log.stamps_s.tolist())
    assert (tmp_path / "out" / "picture.png").read_bytes().startswith(b"\x89PNG")
