"""Requests for other host names are refused where names are set."""

import asyncio
from pathlib import Path
from typing import Any

import httpx
import pytest

from server.addresses import hosts_of
from server.api.security.host_check import HostCheck
from tests.server.api.server_under_test import ServerUnderTest

NAMES = "shuttle.example.org, *.campus.test"


def allows(header: str) -> bool:
    scope = {"type": "http", "headers": [(b"host", header.encode())]}
    return HostCheck(_nothing, hosts_of(NAMES))._allows(scope)


async def _nothing(*_: Any) -> None:
    pytest.fail("the request was served")


def status(tmp_path: Path, host: str, **settings: Any) -> int:
    server = ServerUnderTest(tmp_path, **settings)
    answer = server.get("/health", headers={"Host": host})
    server.close()
    return answer.status_code


@pytest.mark.parametrize(
    "host",
    [
        "shuttle.example.org",
        "SHUTTLE.example.org:8443",
        "a.campus.test",
        "localhost:8080",
        "[::1]:80",
        "127.0.0.1",
    ],
)
def test_named_hosts_and_loopback_are_served(host: str) -> None:
    assert allows(host)


@pytest.mark.parametrize(
    "host", ["evil.example", "campus.test", "shuttle.example.org.evil.example", "192.0.2.7", ""]
)
def test_other_hosts_are_refused(host: str) -> None:
    assert not allows(host)


def test_the_public_address_is_allowed_beside_the_named_hosts(tmp_path: Path) -> None:
    allowed = {"allowed_hosts": NAMES, "public_url": "https://ride.example.edu"}
    assert status(tmp_path, "ride.example.edu", **allowed) == 200


def test_without_names_every_host_is_served(tmp_path: Path) -> None:
    assert status(tmp_path, "evil.example") == 200


def test_a_refusal_is_a_problem_with_the_security_headers(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, allowed_hosts=NAMES)
    answer: httpx.Response = server.get("/health", headers={"Host": "evil.example"})
    server.close()
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers["x-content-type-options"] == "nosniff"


def test_a_websocket_for_another_host_is_closed_before_it_is_accepted() -> None:
    said: list[dict[str, Any]] = []

    async def send(message: Any) -> None:
        said.append(message)

    async def receive() -> Any:
        return {"type": "websocket.connect"}

    scope = {"type": "websocket", "headers": [(b"host", b"evil.example")]}
    asyncio.run(HostCheck(_nothing, ("example.org",))(scope, receive, send))
    assert [message["type"] for message in said] == ["websocket.close"]


@pytest.mark.parametrize("hosts", [[], [(b"host", b"localhost"), (b"host", b"evil.example")]])
def test_a_request_with_no_or_two_hosts_is_refused(hosts: list[tuple[bytes, bytes]]) -> None:
    check = HostCheck(_nothing, ("example.org",))
    assert not check._allows({"type": "http", "headers": hosts})
