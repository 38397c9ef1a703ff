import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from vehicle_agent.runtime.processes.supervisor import Job, Supervisor

pytestmark = pytest.mark.real


def stand(path: str) -> None:
    with Path(path).open("a") as file:
        file.write(f"{os.getpid()}\n")
    time.sleep(60.0)


def until(supervisor: Supervisor, condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < deadline
        supervisor.restart_ended()
        time.sleep(0.02)


def starts(path: Path) -> list[int]:
    return [int(line) for line in path.read_text().splitlines()] if path.exists() else []


def test_a_killed_process_is_started_again_and_all_end_on_stop(tmp_path: Path) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    supervisor = Supervisor([Job("one", stand, (str(one),)), Job("two", stand, (str(two),))])
    supervisor.start()
    until(supervisor, lambda: len(starts(one)) == 1 and len(starts(two)) == 1)
    os.kill(supervisor.pids["one"], signal.SIGKILL)
    until(supervisor, lambda: len(starts(one)) == 2)
    assert len(starts(two)) == 1
    pids = list(supervisor.pids.values())
    supervisor.stop()
    assert supervisor.pids == {}
    for pid in pids:
        assert not Path(f"/proc/{pid}").exists()


def test_a_process_that_is_not_to_be_restarted_stays_ended(tmp_path: Path) -> None:
    supervisor = Supervisor([Job("once", os.getpid, restart=False)])
    supervisor.start()
    until(supervisor, lambda: supervisor.has_ended("once"))
    supervisor.restart_ended()
    assert supervisor.pids == {}
    supervisor.stop()
