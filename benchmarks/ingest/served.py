"""`campusloop serve` in a process of its own, and what the operating system says about it."""

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import psutil

from benchmarks.faults.installation import free_port

PASSWORD = "ingest is measured on purpose"
_READY_WITHIN_S = 180.0
_STOP_WITHIN_S = 60.0


@dataclass(frozen=True, slots=True)
class Usage:
    """Of the process with all its threads, not of its children.

    cpu_s  user and system time; memory_mb: its own (USS); rss_mb: with what it shares
    """

    cpu_s: float
    memory_mb: float
    rss_mb: float


@dataclass(frozen=True, slots=True)
class Served:
    port: int
    process: psutil.Process
    cookie: str = ""

    def usage(self) -> Usage:
        times, memory = self.process.cpu_times(), self.process.memory_full_info()
        return Usage(times.user + times.system, memory.uss / 1e6, memory.rss / 1e6)


def environment(folder: Path, campus_map: Path) -> dict[str, str]:
    return os.environ | {
        "CAMPUSLOOP_VAR_DIR": str(folder),
        "CAMPUSLOOP_MAP_PATH": str(campus_map),
        "CAMPUSLOOP_OPERATOR_PASSWORD": PASSWORD,
    }


def allow_many_files() -> None:
    """Raise the limit of open files as far as this process may; the server inherits it."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


@contextmanager
def served_campus(variables: Mapping[str, str]) -> Iterator[Served]:
    """The server, ready, with an operator's session."""
    port = free_port()
    command = [sys.executable, "-m", "campusloop", "serve", "--port", str(port)]
    journal = Path(variables["CAMPUSLOOP_VAR_DIR"]) / "server.log"
    with process(command, dict(variables), journal) as running:
        origin = f"http://127.0.0.1:{port}/api/v1"
        with httpx.Client(base_url=origin, trust_env=False, timeout=10.0) as http:
            _until_ready(http, running)
            answer = http.post("/session", json={"name": "operator", "password": PASSWORD})
            answer.raise_for_status()
            cookie = "; ".join(f"{name}={value}" for name, value in http.cookies.items())
        yield Served(port, running, cookie)


@contextmanager
def process(
    command: list[str], variables: dict[str, str] | None = None, journal: Path | None = None
) -> Iterator[psutil.Process]:
    """A process that is ended at the end, and killed if it does not obey. journal: where its log goes"""
    with (journal or Path(os.devnull)).open("wb") as log:
        started = subprocess.Popen(command, env=variables, stdout=log, stderr=log)
    try:
        yield psutil.Process(started.pid)
    finally:
        started.send_signal(signal.SIGTERM)
        try:
            started.wait(_STOP_WITHIN_S)
        except subprocess.TimeoutExpired:
            started.kill()
            started.wait()


def _until_ready(http: httpx.Client, running: psutil.Process) -> None:
    until_s = time.monotonic() + _READY_WITHIN_S
    while time.monotonic() < until_s:
        try:
            if http.get("/ready").status_code == 200:
                return
        except httpx.TransportError:
            pass
        if not running.is_running() or running.status() == psutil.STATUS_ZOMBIE:
            sys.exit("the server ended before it was ready")
        time.sleep(0.2)
    sys.exit(f"the server was not ready within {_READY_WITHIN_S:.0f} s")
