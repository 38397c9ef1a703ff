"""One client network may have so many connections; proxies and loopback have no limit."""

import asyncio
from typing import Any

import pytest

from server.addresses import networks_of
from server.api.security.connection_counts import ConnectionCounts
from server.api.security.open_sockets import OpenSockets


def test_a_client_has_so_many_and_gets_another_when_one_has_ended() -> None:
    counts = ConnectionCounts(2)
    assert [counts.opened("192.0.2.7") for _ in range(3)] == [True, True, False]
    assert counts.opened("192.0.2.8")
    counts.closed("192.0.2.7")
    assert [counts.opened("192.0.2.7") for _ in range(2)] == [True, False]


def test_an_ipv6_network_is_one_client() -> None:
    counts = ConnectionCounts(1)
    assert counts.opened("2001:db8::1")
    assert not counts.opened("2001:db8::2")


@pytest.mark.parametrize("peer", ["127.0.0.1", "::1", "10.0.0.1"])
def test_loopback_and_proxies_have_no_limit(peer: str) -> None:
    counts = ConnectionCounts(1, networks_of("10.0.0.0/8"))
    assert all(counts.opened(peer) for _ in range(5))


def test_nothing_is_remembered_of_clients_that_have_gone() -> None:
    counts = ConnectionCounts(1)
    for number in range(5):
        peer = f"192.0.2.{number}"
        counts.opened(peer)
        counts.closed(peer)
    assert not counts._open


def test_a_client_behind_a_proxy_has_so_many_websockets() -> None:
    said: list[str] = []

    async def scenario() -> None:
        goes_on = asyncio.Event()

        async def app(*_: Any) -> None:
            said.append("served")
            await goes_on.wait()

        async def send(message: Any) -> None:
            said.append(message["type"])

        async def receive() -> Any:
            return {"type": "websocket.connect"}

        sockets = OpenSockets(app, per_client_max=1)
        scope = {"type": "websocket", "client": ("192.0.2.7", 4711)}
        first = asyncio.create_task(sockets(scope, receive, send))
        await asyncio.sleep(0)
        await sockets(scope, receive, send)
        goes_on.set()
        await first
        await sockets(scope, receive, send)

    asyncio.run(scenario())
    assert said == ["served", "websocket.close", "served"]
