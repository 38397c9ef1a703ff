"""The units for systemd: their commands exist, and their settings are settings."""

import configparser
import subprocess
import sys
from pathlib import Path

import pytest

from campusloop.live.process_end import CANNOT_WORK, END_WITHIN_S
from server.settings import settings_from

UNITS = Path(__file__).resolve().parents[2] / "deploy" / "systemd"


def a_unit(name: str) -> configparser.ConfigParser:
    unit = configparser.ConfigParser(interpolation=None, strict=False)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read(UNITS / name)
    return unit


@pytest.mark.parametrize("name", ["campusloop-server.service", "campusloop-agent@.service"])
def test_a_unit_runs_a_command_of_ours_and_starts_it_again(name: str) -> None:
    unit = a_unit(name)
    program, *arguments = unit["Service"]["ExecStart"].split()
    assert program.endswith("/bin/campusloop")
    words = [word for word in arguments if not word.startswith("/")]
    shown = subprocess.run(
        [sys.executable, "-m", "campusloop", *words, "--help"], capture_output=True, timeout=60, check=False
    )
    assert shown.returncode == 0, shown.stderr
    assert unit["Service"]["Restart"] == "always"
    assert str(CANNOT_WORK) not in unit["Service"].get("RestartPreventExitStatus", "")


def test_the_servers_unit_waits_longer_than_the_server_takes_to_stop() -> None:
    assert float(a_unit("campusloop-server.service")["Service"]["TimeoutStopSec"]) > END_WITHIN_S


def test_every_line_of_the_example_is_a_setting_that_can_be_used() -> None:
    lines = (UNITS / "server.env").read_text(encoding="utf-8").splitlines()
    given = dict(line.split("=", 1) for line in lines if line and not line.startswith("#"))
    settings = settings_from(given)
    assert len(given) == 10
    assert {name.removeprefix("CAMPUSLOOP_").lower() for name in given} <= set(type(settings).model_fields)
    assert settings.has_tls()
