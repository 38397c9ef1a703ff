"""Vehicles that look for road users by themselves have a worker each; the others share one."""

from pathlib import Path

from campusloop.shipped import DEFAULT_MAP, PROFILES
from vehicle_agent.config import load_profile, profile_toml
from vehicle_agent.runtime.processes.agent import AgentPlace
from vehicle_agent.runtime.processes.agent_files import AgentFolder, VehicleFile
from vehicle_agent.runtime.processes.agent_jobs import worker_jobs


def a_place(folder: Path, name: str, profile: Path | None) -> AgentPlace:
    vehicle = VehicleFile(
        name, "https://127.0.0.1:1", "udp:239.1.1.1:1", 1, 2, 3, str(folder / name / "scans")
    )
    AgentFolder(folder / name).prepare(vehicle, DEFAULT_MAP, profile)
    return AgentPlace(folder / name, folder / "mail" / name)


def sighted(folder: Path) -> Path:
    text = profile_toml(load_profile(PROFILES / "snow-lion.toml"))
    path = folder / "sighted.toml"
    path.write_text(text.replace('perception = "tracker"', 'perception = "own"'))
    assert load_profile(path).perception == "own"
    return path


def test_shuttles_told_of_road_users_share_a_worker(tmp_path: Path) -> None:
    places = (a_place(tmp_path, "shuttle-1", None), a_place(tmp_path, "shuttle-2", None))
    assert [job.name for job in worker_jobs(places)] == ["worker"]


def test_shuttles_that_see_have_one_each(tmp_path: Path) -> None:
    profile = sighted(tmp_path)
    places = (
        a_place(tmp_path, "shuttle-1", profile),
        a_place(tmp_path, "shuttle-2", profile),
        a_place(tmp_path, "shuttle-3", None),
    )
    assert [job.name for job in worker_jobs(places)] == ["worker shuttle-1", "worker shuttle-2", "worker"]
