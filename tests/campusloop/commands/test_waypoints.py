"""`campusloop waypoints` from the outside."""

import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.virtual.solo_drive import VEHICLE_ID, SoloDrive
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route
from tests.server.feeds.roads.shipped import CAMPUS_MAP
from vehicle_agent.planning.waypoint.waypoints import WaypointRules
from vehicle_agent.waypoints.files import read_waypoints

RUN = CliRunner()


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray]:
    """A recorded drive of 15 s, and where the shuttle truly was (n, 2)."""
    folder = tmp_path_factory.mktemp("drive")
    drive = SoloDrive(load_map(CAMPUS_MAP), folder, 1)
    drive.set_off()
    truth = []
    for _ in range(750):
        drive.step()
        pose = drive.world.truth(VEHICLE_ID).pose_map
        truth.append((pose.x_m, pose.y_m))
    drive.vehicle.shut_down()
    return folder, np.array(truth)


def test_a_recorded_drive_becomes_a_file_for_each_speed(
    driven: tuple[Path, np.ndarray], tmp_path: Path
) -> None:
    folder, truth = driven
    done = RUN.invoke(
        app_of(),
        ["waypoints", "record", str(folder), "--out", str(tmp_path), "--speed", "1.5", "--speed", "2.5"],
    )
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drive-1.5mps.csv", "drive-2.5mps.csv"]
    slow = read_waypoints(tmp_path / "drive-1.5mps.csv", load_map(CAMPUS_MAP).origin, WaypointRules())
    assert np.all(slow.speeds_mps <= 1.5)
    off_m = [np.min(np.hypot(*(truth - point).T)) for point in slow.points_map]
    assert max(off_m) < 0.2
    assert slow.s_m[-1] == pytest.approx(np.sum(np.hypot(*np.diff(truth, axis=0).T)), abs=1.5)


def test_a_route_is_as_long_as_the_road_and_slow_in_its_curves(tmp_path: Path) -> None:
    done = RUN.invoke(
        app_of(),
        ["waypoints", "route", "stop-1", "stop-5", "--map", str(CAMPUS_MAP), "--out", str(tmp_path)],
    )
    assert done.exit_code == 0, done.output
    road_map = load_map(CAMPUS_MAP)
    first, last = (next(s for s in road_map.stops if s.stop_id == name) for name in ("stop-1", "stop-5"))
    route = find_route(RoadNetwork(road_map), first.lane_id, first.s_m, last.lane_id, last.s_m)
    assert route is not None
    fast = read_waypoints(tmp_path / "stop-1-to-stop-5-3.0mps.csv", road_map.origin, WaypointRules())
    assert fast.s_m[-1] == pytest.approx(route.length_m, abs=1.0)
    assert fast.speeds_mps.max() == pytest.approx(3.0)
    # Turns of 6 m or so: sqrt(0.5 r).
    assert math.sqrt(0.5 * 5.0) * 0.9 < fast.speeds_mps.min() < 2.2


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["record", "nowhere"], "nowhere"),
        (["record", "."], "No segments"),
        (["route", "stop-1", "stop-99", "--map", str(CAMPUS_MAP)], "there are: stop-1, stop-2"),
        (["route", "stop-1", "stop-1", "--map", str(CAMPUS_MAP)], "no route from stop-1 to stop-1"),
        (["route", "stop-1", "stop-5", "--map", "nowhere.json"], "nowhere.json"),
    ],
)
def test_what_cannot_be_written_is_said_and_ends_with_2(
    arguments: list[str], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = RUN.invoke(app_of(), ["waypoints", *arguments])
    assert done.exit_code == 2
    assert says in done.output
    assert list(tmp_path.iterdir()) == []
