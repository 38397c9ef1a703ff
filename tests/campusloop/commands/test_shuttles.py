"""`campusloop shuttles`: what is given reaches the simulated shuttles."""

from typing import Any

import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.commands import shuttles
from campusloop.live.shuttles import ShuttleOptions


def test_plant_seed_and_scene_reach_the_simulator(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[ShuttleOptions] = []

    def refused(options: ShuttleOptions) -> Any:
        given.append(options)
        raise OSError("enough")

    monkeypatch.setenv("CAMPUSLOOP_OPERATOR_PASSWORD", "a long enough password")
    monkeypatch.setattr(shuttles, "SimulatedShuttles", refused)
    monkeypatch.setattr(shuttles, "prepare_kernels", lambda groups, console: None)
    command = ["shuttles", "--server", "https://localhost:1"]
    result = CliRunner().invoke(app_of(["shuttles"]), [*command, "--plant-seed", "7", "--scene"])
    assert result.exit_code == shuttles.EXIT_BAD_INPUT
    CliRunner().invoke(app_of(["shuttles"]), command)
    assert [options.plant_seed for options in given] == [7, None]
    assert [options.scene is None for options in given] == [False, True]
