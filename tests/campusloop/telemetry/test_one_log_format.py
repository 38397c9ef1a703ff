"""Every line that a real process logs is one JSON object with the same keys, in good times and in bad."""

import json
import socket
import sqlite3
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest

from tests.campusloop.telemetry.running_commands import free_port, running
from tests.server.api.server_under_test import MAPS

KEYS = ["timestamp", "level", "event", "process"]
WITHIN_S = 90.0
MAP = str(MAPS / "snow-lion" / "map.json")

pytestmark = [pytest.mark.real, pytest.mark.long]


def lines_of(folder: Path) -> list[dict[str, Any]]:
    """All lines of all logs, except one that is not complete yet. Fails where one is no JSON object."""
    lines = []
    for path in sorted(folder.rglob("*.log")):
        for line in path.read_text(encoding="utf-8").splitlines(keepends=True):
            if line.endswith("\n"):
                fields = json.loads(line)
                assert list(fields)[:4] == KEYS, (path.name, line)
                lines.append(fields)
    return lines


def until(folder: Path, what: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """The first line for which this is true. Fails if there is none in time."""
    for _ in range(round(WITHIN_S / 0.2)):
        for fields in lines_of(folder):
            if what(fields):
                return fields
        time.sleep(0.2)
    raise AssertionError(lines_of(folder)[-20:])


def event(name: str) -> Callable[[dict[str, Any]], bool]:
    return lambda fields: fields["event"] == name


def test_all_processes_of_a_campus_log_in_one_format(tmp_path: Path) -> None:
    port = free_port()
    origin = f"http://127.0.0.1:{port}"
    shuttles = ("shuttles", "--server", origin, "--count", "1", "--map", MAP, "--folder", str(tmp_path / "s"))
    with (
        running(tmp_path, "serve", "serve", "--port", str(port), "--map", MAP),
        running(tmp_path, "shuttles", *shuttles) as fleet,
    ):
        until(tmp_path, event("link.opened"))
        # A library's own message, at level warning.
        with socket.create_connection(("127.0.0.1", port)) as raw:
            raw.sendall(b"no HTTP at all\r\n\r\n")
        assert until(tmp_path, lambda fields: fields.get("logger") == "uvicorn.error")["level"] == "warning"
        # A process that is killed, and a standing task that fails.
        tick = next(
            child
            for child in psutil.Process(fleet.pid).children()
            if "spawn_main" in " ".join(child.cmdline())
        )
        tick.kill()
        assert until(tmp_path, event("process.ended"))["level"] == "error"
        with closing(sqlite3.connect(tmp_path / "var" / "campusloop.db")) as database:
            database.execute("ALTER TABLE incidents RENAME TO lost_incidents")
            database.commit()
        failed = until(tmp_path, event("task.failed"))
        assert failed["exception"][0]["exc_type"]
        key = {"X-Request-Id": "from-the-test"}
        assert httpx.get(f"{origin}/api/v1/ready", headers=key, trust_env=False).headers["x-request-id"]
    processes = {fields["process"] for fields in lines_of(tmp_path)}
    assert {"server", "shuttles", "link"} <= processes, processes


@pytest.mark.parametrize("command", ["serve", "agent run", "simulate", "shuttles", "demo"])
def test_a_command_refuses_bad_input_in_the_format_of_the_log(command: str, tmp_path: Path) -> None:
    options = {
        "agent run": [str(tmp_path / "nowhere")],
        "simulate": ["--map", "nowhere.json", "--vehicles", "shuttle-1"],
        "shuttles": ["--server", "http://127.0.0.1:9", "--map", "nowhere.json"],
    }
    arguments = options.get(command, ["--map", "nowhere.json"])
    with running(tmp_path, "refused", *command.split(), *arguments) as process:
        assert process.wait(WITHIN_S) == 2
    assert [fields for fields in lines_of(tmp_path) if "nowhere" in json.dumps(fields)], lines_of(tmp_path)
