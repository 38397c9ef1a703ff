"""Run segments in an S3 bucket, over HTTP."""

import hashlib
import os
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from server.store.segments.choice import open_segment_store

pytestmark = pytest.mark.real
SERVER = Path(__file__).resolve().parents[4] / "var" / "generators" / "bin" / "moto_server"
# Larger than a part of an upload in parts.
DATA = os.urandom(12 << 20)
SHA256 = hashlib.sha256(DATA).hexdigest()


@pytest.fixture
def s3(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The URL of a bucket of a running server."""
    if not SERVER.exists():
        pytest.skip("no S3 server is installed: make generators")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    origin = f"http://127.0.0.1:{port}"
    process = subprocess.Popen(
        [SERVER, "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        for _ in range(200):
            try:
                assert httpx.put(f"{origin}/campus").status_code == 200
                break
            except httpx.TransportError:
                time.sleep(0.1)
        for name, value in {
            "AWS_ENDPOINT_URL": origin,
            "AWS_ACCESS_KEY_ID": "key",
            "AWS_SECRET_ACCESS_KEY": "secret",
        }.items():
            monkeypatch.setenv(name, value)
        yield "s3://campus/runs"
    finally:
        process.kill()
        process.wait()


def test_a_segment_that_one_replica_took_is_read_by_another(s3: str, tmp_path: Path) -> None:
    one, other = (open_segment_store(s3, tmp_path / name, len(DATA)) for name in ("one", "other"))
    assert not one.has(SHA256)
    assert one.fetch(SHA256) is None
    with one.receive(SHA256, "upload") as incoming:
        incoming.write(DATA)
        incoming.prove()
        one.keep(incoming)
    assert other.has(SHA256)
    path = other.fetch(SHA256)
    assert path is not None
    assert path.read_bytes() == DATA
