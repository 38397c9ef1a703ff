"""What an agent refuses at its start, before it drives."""

import shutil
from pathlib import Path

import msgspec
import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.shipped import PROFILES
from contract.roads.load import encode_map
from tests.contract.roads.ring_map import ring_map
from vehicle_agent.config import load_profile, profile_toml
from vehicle_agent.perception.pillars import detector
from vehicle_agent.perception.pillars.detector_file import DEFAULT_DETECTOR, read_detector_file, record_path
from vehicle_agent.runtime.processes.agent_files import AgentFolder, VehicleFile


def test_an_agent_whose_detector_is_damaged_is_refused_at_its_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    campus_map, profile = tmp_path / "map.json", tmp_path / "own.toml"
    campus_map.write_bytes(encode_map(ring_map()))
    own = msgspec.structs.replace(load_profile(PROFILES / "snow-lion.toml"), perception="own")
    profile.write_text(profile_toml(own))
    (tmp_path / "vehicle").mkdir()
    AgentFolder(tmp_path / "vehicle").prepare(
        VehicleFile("shuttle-1", "http://127.0.0.1:1", "udp:239.1.1.1:1", 1, 2, 3, "scans"),
        campus_map,
        profile,
    )
    damaged = tmp_path / "detector.onnx"
    damaged.write_bytes(DEFAULT_DETECTOR.read_bytes()[:-100])
    shutil.copyfile(record_path(DEFAULT_DETECTOR), record_path(damaged))
    monkeypatch.setattr(detector, "read_detector_file", lambda path: read_detector_file(damaged))
    result = CliRunner().invoke(app_of(("agent",)), ["agent", "run", str(tmp_path / "vehicle")])
    assert result.exit_code == 2
    assert "detector.onnx is not the file that its record names" in result.output
