"""Which vehicles have a localization worker, and which are refused one."""

from pathlib import Path

import msgspec
import pytest
from rich.console import Console
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.shipped import DEFAULT_MAP, PROFILES
from contract.roads.load import load_map
from tests.contract.localization_folders import point_map
from vehicle_agent.runtime.processes.agent import AgentPlace
from vehicle_agent.runtime.processes.agent_files import AgentFolder, VehicleFile
from vehicle_agent.runtime.processes.agent_jobs import agent_jobs

SNOW_LION = PROFILES / "snow-lion.toml"
VEHICLE = VehicleFile("shuttle-7", "https://127.0.0.1:1", "udp:239.1.1.1:1", 1, 2, 3, "scans")


def a_vehicle(folder: Path, *, by_scans: bool, profile: Path | None = SNOW_LION) -> AgentFolder:
    files = AgentFolder(folder)
    files.prepare(msgspec.structs.replace(VEHICLE, by_scans=by_scans), DEFAULT_MAP, profile)
    return files


def has_worker(files: AgentFolder) -> bool:
    place = AgentPlace(files.root, files.root / "mail")
    return "localization shuttle-7" in [job.name for job in agent_jobs((place,))]


def test_a_vehicle_that_compares_scans_has_a_worker_before_it_has_a_map(tmp_path: Path) -> None:
    waiting = a_vehicle(tmp_path / "waiting", by_scans=True)
    assert (waiting.localizes_by(), waiting.checked_point_map()) == ("points", None)
    assert has_worker(waiting)
    assert not has_worker(a_vehicle(tmp_path / "gnss", by_scans=False))


def test_a_map_given_by_hand_makes_a_vehicle_compare_scans(tmp_path: Path) -> None:
    files = a_vehicle(tmp_path / "vehicle", by_scans=False)
    point_map(tmp_path / "map", load_map(DEFAULT_MAP).origin)
    files.install_point_map(tmp_path / "map")
    assert has_worker(files)
    files.remove_point_map()
    assert not has_worker(files)


def without_lidar(folder: Path) -> Path:
    profile = folder / "blind.toml"
    profile.write_text(SNOW_LION.read_text().replace("rate_hz = 10.0", "rate_hz = 0.0"))
    return profile


def test_a_vehicle_without_scans_does_not_start_with_the_wish_to_compare_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The console of long commands sets the log of the whole process, which other tests read.
    monkeypatch.setattr("campusloop.commands.agent.journal_console", lambda **_options: Console())
    files = a_vehicle(tmp_path / "vehicle", by_scans=True, profile=without_lidar(tmp_path))
    ran = CliRunner().invoke(app_of(["agent"]), ["agent", "run", str(files.root)])
    assert ran.exit_code == 2
    assert "snow-lion has no [lidar] whose scans" in ran.output.replace("\n", " ")


def test_a_vehicle_without_scans_is_not_enrolled_with_the_wish_to_compare_them(tmp_path: Path) -> None:
    arguments = {
        "--server": "http://127.0.0.1:1",
        "--vehicle-id": "shuttle-7",
        "--code": "once",
        "--map": str(DEFAULT_MAP),
        "--can": "can0",
        "--scan-ring": str(tmp_path / "scans"),
        "--profile": str(without_lidar(tmp_path)),
    }
    given = [text for pair in arguments.items() for text in pair]
    ran = CliRunner().invoke(
        app_of(["agent"]), ["agent", "enrol", str(tmp_path / "vehicle"), *given, "--by-scans"]
    )
    assert ran.exit_code == 2
    assert "snow-lion has no [lidar] whose scans" in ran.output.replace("\n", " ")
    assert not (tmp_path / "vehicle" / "vehicle.toml").exists()
