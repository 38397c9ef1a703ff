"""`campusloop` commands as real processes, with what they say in files."""

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from tests.server.api.server_under_test import PASSWORD


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


@contextmanager
def running(
    folder: Path, name: str, *arguments: str, environment: Mapping[str, str] | None = None
) -> Iterator[subprocess.Popen[bytes]]:
    """`campusloop ARGUMENTS`, both its streams in folder/NAME.log. environment: more variables."""
    variables = os.environ | {
        "CAMPUSLOOP_VAR_DIR": str(folder / "var"),
        "CAMPUSLOOP_OPERATOR_PASSWORD": PASSWORD,
        **(environment or {}),
    }
    with (folder / f"{name}.log").open("wb") as log:
        process = subprocess.Popen(
            [sys.executable, "-W", "always", "-m", "campusloop", *arguments],
            env=variables,
            stdout=log,
            stderr=subprocess.STDOUT,
        )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(30)
