"""A vehicle with a sensors.toml has processes that read its sensors; a wrong file is refused at the start."""

from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.shipped import DEFAULT_MAP
from vehicle_agent.runtime.processes import agent_jobs as jobs_of_agents
from vehicle_agent.runtime.processes.agent import AgentPlace
from vehicle_agent.runtime.processes.agent_files import AgentFolder, VehicleFile
from vehicle_agent.runtime.processes.agent_jobs import agent_jobs
from vehicle_agent.runtime.sensors.sensors_file import SensorsError
from vehicle_agent.runtime.video.cameras_file import CamerasError

PLACE = "place = { x_m = 0.0, y_m = 0.0, z_m = 2.0 }\n"
LIDAR = f'[lidars.roof]\nlisten = "udp:2368"\n{PLACE}'
INERTIAL = f'[inertial.vn]\nsource = "/dev/ttyUSB0"\n{PLACE}'


def a_vehicle(folder: Path, sensors: str | None, profile: Path | None = None) -> AgentPlace:
    files = AgentFolder(folder)
    vehicle = VehicleFile(
        "shuttle-7", "https://127.0.0.1:1", "udp:239.1.1.1:1", 1, 2, 3, str(folder / "scans")
    )
    files.prepare(vehicle, DEFAULT_MAP, profile)
    if sensors is not None:
        (folder / "sensors.toml").write_text(sensors)
    return AgentPlace(folder, folder / "mail")


def sensor_jobs_of(place: AgentPlace) -> list[str]:
    names = [job.name for job in agent_jobs((place,))]
    return [name for name in names if name.startswith(("lidars", "receivers", "scanners"))]


def test_each_kind_of_sensor_has_a_process(tmp_path: Path) -> None:
    assert sensor_jobs_of(a_vehicle(tmp_path / "none", None)) == []
    assert sensor_jobs_of(a_vehicle(tmp_path / "a", LIDAR)) == ["lidars shuttle-7"]
    assert sensor_jobs_of(a_vehicle(tmp_path / "b", INERTIAL)) == ["receivers shuttle-7"]
    both = sensor_jobs_of(a_vehicle(tmp_path / "c", LIDAR + INERTIAL))
    assert both == ["lidars shuttle-7", "receivers shuttle-7"]


SCANNERS = '[planar_scanner]\nsource = "tcp:10.0.0.9:2111"\n[people_scanner]\nsource = "tcp:10.0.0.8:2111"\n'
NUS_CART = Path("vehicle_agent/profiles/nus-cart.toml")


def test_a_carts_planar_scanners_have_one_process(tmp_path: Path) -> None:
    assert sensor_jobs_of(a_vehicle(tmp_path, SCANNERS, NUS_CART)) == ["scanners shuttle-7"]


def test_a_scanner_that_the_profile_does_not_have_is_refused(tmp_path: Path) -> None:
    place = a_vehicle(tmp_path, SCANNERS)
    with pytest.raises(SensorsError, match=r"has no \[planar_scanner\]: its rate_hz is 0"):
        AgentFolder(place.folder).sensors()


def test_cameras_have_one_process_where_their_library_is_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = a_vehicle(tmp_path, None)
    text = '[cameras.front]\nsource = "ring"\n[cameras.rear]\nsource = "ring"\n'
    (place.folder / "cameras.toml").write_text(text)
    for is_there, expected in ((True, ["video shuttle-7"]), (False, [])):
        monkeypatch.setattr(jobs_of_agents, "is_installed", lambda is_there=is_there: is_there)
        names = [job.name for job in agent_jobs((place,))]
        assert [name for name in names if name.startswith("video")] == expected


def test_a_carts_camera_for_people_has_a_process_and_is_not_recorded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = a_vehicle(tmp_path / "a", None, NUS_CART)
    (place.folder / "cameras.toml").write_text('[people_camera]\nsource = "/dev/video0"\n')
    for is_there, expected in ((True, ["camera shuttle-7"]), (False, [])):
        monkeypatch.setattr(jobs_of_agents, "is_installed", lambda is_there=is_there: is_there)
        names = [job.name for job in agent_jobs((place,))]
        assert [name for name in names if name.startswith(("video", "camera"))] == expected
    without = a_vehicle(tmp_path / "b", None)
    (without.folder / "cameras.toml").write_text('[people_camera]\nsource = "/dev/video0"\n')
    with pytest.raises(CamerasError, match=r"has no \[camera\]: its rate_hz is 0"):
        AgentFolder(without.folder).people_camera()


def test_an_agent_whose_sensors_cannot_be_read_does_not_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The console of long commands sets the log of the whole process, which other tests read.
    monkeypatch.setattr("campusloop.commands.agent.journal_console", lambda **_options: Console())
    place = a_vehicle(tmp_path, LIDAR.replace("udp:2368", "usb"))
    ran = CliRunner().invoke(app_of(["agent"]), ["agent", "run", str(place.folder)])
    assert ran.exit_code == 2
    assert "sensors.toml" in ran.output
    assert "'usb' is none of /dev/NAME, tcp:HOST:PORT, udp:PORT" in ran.output.replace("\n", " ")
