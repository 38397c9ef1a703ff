"""`campusloop serve`: where it listens, how it is secured, and when it refuses to start."""

import asyncio
import os
import re
import signal
import socket
import ssl
import subprocess
import sys
from pathlib import Path

import httpx
import pytest

from campusloop.live.server import listen, secured
from server.live_ports import CannotStart, live_ports
from server.settings import SettingsError, settings_from
from tests.server.api.server_under_test import MAPS

SNOW_LION = str(MAPS / "snow-lion" / "map.json")


def test_loopback_needs_no_tls_and_everything_else_gets_it(tmp_path: Path) -> None:
    assert not secured(settings_from({}, var_dir=tmp_path)).has_tls()
    outside = secured(settings_from({}, var_dir=tmp_path, host="0.0.0.0"))
    assert outside.has_tls()
    assert outside.origin().startswith("https://")
    assert (tmp_path / "tls" / "certificate.pem") == outside.tls_cert


def test_plain_http_for_others_must_be_said_and_contradicts_a_certificate(tmp_path: Path) -> None:
    outside = settings_from({}, var_dir=tmp_path, host="0.0.0.0")
    assert not secured(outside, plain=True).has_tls()
    with pytest.raises(SettingsError, match="--no-tls"):
        secured(outside, make_certificate=True, plain=True)


def test_a_certificate_that_is_none_is_refused_before_anything_starts(tmp_path: Path) -> None:
    for name in ("cert.pem", "key.pem"):
        (tmp_path / name).write_text("nothing")
    settings = settings_from({}, tls_cert=tmp_path / "cert.pem", tls_key=tmp_path / "key.pem")
    with pytest.raises(SettingsError, match="cannot be used for TLS"):
        secured(settings)


def test_a_taken_port_is_named_with_what_to_do() -> None:
    taken = listen("127.0.0.1", 0)
    port = taken.getsockname()[1]
    with pytest.raises(CannotStart, match=rf"port {port} .* is in use"):
        listen("127.0.0.1", port)
    taken.close()


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"map_path": "nowhere.json"}, "nowhere.json"),
        ({"map_path": None}, "--map"),
        ({"database_url": "postgresql://u:hush@127.0.0.1:1/x"}, "CAMPUSLOOP_DATABASE_URL"),
        ({"database_url": "mysql://x"}, "sqlite"),
        ({"bus_url": "nats://127.0.0.1:1"}, "NATS"),
        ({"ticket_key_file": "/dev/null"}, "CAMPUSLOOP_TICKET_KEY_FILE"),
        ({"service_opens": "20:00", "service_closes": "08:00"}, "SERVICE_OPENS"),
    ],
)
def test_what_is_missing_is_named_with_what_to_do(
    tmp_path: Path, changes: dict[str, object], text: str
) -> None:
    settings = settings_from({}, **({"var_dir": tmp_path, "map_path": SNOW_LION} | changes))
    with pytest.raises(CannotStart, match=text) as refusal:
        asyncio.run(live_ports(settings))
    assert "hush" not in str(refusal.value)


def test_a_second_server_on_the_same_sqlite_file_refuses_to_start(tmp_path: Path) -> None:
    settings = settings_from({}, var_dir=tmp_path, map_path=SNOW_LION)

    async def scenario() -> None:
        first = await live_ports(settings)
        with pytest.raises(CannotStart, match=r"in use by another server .* stop it"):
            await live_ports(settings)
        await first.ports.close()
        again = await live_ports(settings)
        await again.ports.close()

    asyncio.run(scenario())


def test_a_server_with_another_ticket_key_than_its_database_refuses_to_start(tmp_path: Path) -> None:
    settings = settings_from({}, var_dir=tmp_path, map_path=SNOW_LION)

    async def scenario() -> None:
        first = await live_ports(settings)
        await first.ports.close()
        (tmp_path / "ticket.key").unlink()
        with pytest.raises(CannotStart, match=r"ticket_key_missing: .* copy of the file"):
            await live_ports(settings)

    asyncio.run(scenario())


def test_the_command_refuses_to_start_with_one_clear_line(tmp_path: Path) -> None:
    refused = subprocess.run(
        [sys.executable, "-m", "campusloop", "serve", "--port", "0", "--map", "nowhere.json"],
        env=os.environ | {"CAMPUSLOOP_VAR_DIR": str(tmp_path), "NO_COLOR": "1"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert refused.returncode == 2
    assert "nowhere.json" in refused.stderr
    assert "Traceback" not in refused.stderr


@pytest.mark.real
def test_a_phone_on_the_network_gets_the_server_over_tls(tmp_path: Path) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    server = subprocess.Popen(
        [
            *(sys.executable, "-m", "campusloop", "serve", "--map", SNOW_LION),
            *("--host", "0.0.0.0", "--port", str(port)),
        ],
        env=os.environ | {"CAMPUSLOOP_VAR_DIR": str(tmp_path), "NO_COLOR": "1"},
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert server.stderr is not None
        said = ""
        while "server.started" not in said:
            line = server.stderr.readline()
            assert line, said
            said += line
        trust = ssl.create_default_context(cafile=str(tmp_path / "tls" / "certificate.pem"))
        answer = httpx.get(f"https://127.0.0.1:{port}/api/v1/ready", verify=trust, trust_env=False)
        assert answer.json()["ready"] is True
        assert "strict-transport-security" in answer.headers
        assert re.search(rf"https://[^ ]+:{port}/console", said)
        assert "shown once" in said
    finally:
        server.send_signal(signal.SIGINT)
        assert server.wait(20) in (0, -signal.SIGINT, 130)
