"""Webhooks reach public addresses only, follow no redirect, and wait and read within limits."""

import asyncio
import ssl
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from ipaddress import ip_address
from pathlib import Path

import pytest

from campusloop.live.certificate import self_signed
from server import webhook_sender
from server.addresses import LOOPBACK, networks_of
from server.usecases.ports.webhooks import WebhookAnswer
from server.webhook_sender import HttpWebhookSender, is_public

OK = b"HTTP/1.1 204 No Content\r\n\r\n"
PRIVATE = [
    "127.0.0.1",
    "10.1.2.3",
    "172.16.0.1",
    "192.168.1.1",
    "169.254.169.254",
    "100.64.0.1",
    "0.0.0.0",
    "224.0.0.1",
    "255.255.255.255",
    "240.0.0.1",
    "198.18.0.1",
    "::",
    "::1",
    "fe80::1",
    "fc00::1",
    "ff02::1",
    "::ffff:127.0.0.1",
    "64:ff9b::7f00:1",
    "2002:7f00:1::",
]


class Receiver:
    """Notes whole requests and answers each connection with the next bytes."""

    def __init__(self, *answers: bytes) -> None:
        self.requests: list[bytes] = []
        self._answers = list(answers)
        self.port = 0

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = await reader.readuntil(b"\r\n\r\n")
        length = next(
            int(line.split(b":")[1])
            for line in head.split(b"\r\n")
            if line.lower().startswith(b"content-length")
        )
        self.requests.append(head + await reader.readexactly(length))
        writer.write(self._answers.pop(0))
        await writer.drain()
        writer.close()


@asynccontextmanager
async def receiving(receiver: Receiver, tls: ssl.SSLContext | None = None) -> AsyncIterator[Receiver]:
    server = await asyncio.start_server(receiver.serve, "127.0.0.1", 0, ssl=tls)
    receiver.port = server.sockets[0].getsockname()[1]
    async with server:
        yield receiver


def names(**addresses: Sequence[str]) -> Callable[[str, int], Awaitable[Sequence[str]]]:
    """A resolver that knows these names, one answer after the other; it fails when asked once more."""
    left = {name: list(found) for name, found in addresses.items()}

    async def resolve(host: str, port: int) -> Sequence[str]:
        return [left[host].pop(0)]

    return resolve


async def sent(sender: HttpWebhookSender, url: str) -> WebhookAnswer:
    async with asyncio.timeout(20):
        answer = await sender.send(url, {"webhook-id": "m-1"}, b"{}")
        await sender.close()
        return answer


@pytest.mark.parametrize("address", PRIVATE)
def test_an_address_of_an_inner_network_is_not_public(address: str) -> None:
    assert not is_public(ip_address(address))


@pytest.mark.parametrize("address", ["93.184.216.34", "2606:2800:220:1::1", "64:ff9b::5db8:d822"])
def test_an_address_of_the_internet_is_public(address: str) -> None:
    assert is_public(ip_address(address))


@pytest.mark.parametrize("scheme", ["http", "https"])
@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "2130706433", "[::1]"])
def test_a_receiver_on_this_machine_is_not_even_connected_to(scheme: str, host: str) -> None:
    async def claim() -> WebhookAnswer:
        async with receiving(Receiver(OK)) as receiver:
            answer = await sent(HttpWebhookSender(), f"{scheme}://{host}:{receiver.port}/")
            assert receiver.requests == []
            return answer

    answer = asyncio.run(claim())
    assert answer.status == 0
    assert "may not reach" in answer.failure


def test_a_public_address_without_tls_is_refused() -> None:
    answer = asyncio.run(sent(HttpWebhookSender(resolve=names(hooks=["93.184.216.34"])), "http://hooks/"))
    assert "may not reach" in answer.failure


def test_one_inner_address_among_others_is_enough_to_refuse() -> None:
    async def resolve(_host: str, _port: int) -> Sequence[str]:
        return ["93.184.216.34", "10.0.0.1"]

    assert "may not reach" in asyncio.run(sent(HttpWebhookSender(resolve=resolve), "https://hooks/")).failure


def test_a_name_that_changes_its_address_is_resolved_once_and_connected_to_as_checked() -> None:
    async def claim() -> None:
        async with receiving(Receiver(OK)) as receiver:
            sender = HttpWebhookSender(networks_of("127.0.0.1"), resolve=names(hooks=["127.0.0.1"]))
            assert (await sent(sender, f"http://hooks:{receiver.port}/campus?x=1")).failure == ""
            (request,) = receiver.requests
            assert request.startswith(b"POST /campus?x=1 HTTP/1.1\r\n")
            assert b"webhook-id: m-1\r\n" in request
            assert request.endswith(b"\r\n\r\n{}")

    asyncio.run(claim())


def test_an_allowed_network_does_not_allow_another_one() -> None:
    sender = HttpWebhookSender(networks_of("10.0.0.0/8"), resolve=names(hooks=["192.168.0.1"]))
    assert "may not reach" in asyncio.run(sent(sender, "http://hooks/")).failure


def test_a_redirect_is_a_failure_and_is_not_followed() -> None:
    async def claim() -> None:
        async with receiving(Receiver(OK)) as target:
            moved = f"HTTP/1.1 307 Moved\r\nLocation: http://127.0.0.1:{target.port}/\r\n\r\n".encode()
            async with receiving(Receiver(moved)) as first:
                answer = await sent(HttpWebhookSender(LOOPBACK), f"http://127.0.0.1:{first.port}/")
            assert answer.failure == "it answered 307"
            assert target.requests == []

    asyncio.run(claim())


def test_an_answer_without_end_is_not_read() -> None:
    endless = b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n" + b"1000\r\n" + b"a" * 100

    async def claim() -> None:
        async with receiving(Receiver(endless)) as receiver:
            answer = await sent(HttpWebhookSender(LOOPBACK), f"http://127.0.0.1:{receiver.port}/")
            assert answer.failure == ""

    asyncio.run(claim())


def test_a_receiver_that_does_not_answer_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webhook_sender, "ATTEMPT_S_MAX", 0.2)

    async def silent(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read()
        writer.close()

    async def claim() -> None:
        server = await asyncio.start_server(silent, "127.0.0.1", 0)
        async with server:
            port = server.sockets[0].getsockname()[1]
            answer = await sent(HttpWebhookSender(LOOPBACK), f"http://127.0.0.1:{port}/")
            assert "no answer within" in answer.failure

    asyncio.run(claim())


def test_a_closed_port_and_an_unknown_name_are_failures_that_do_not_name_the_address() -> None:
    for url in ("http://127.0.0.1:9/secret-path", "https://no-such-name.invalid/secret-path"):
        answer = asyncio.run(sent(HttpWebhookSender(LOOPBACK), url))
        assert answer.status == 0
        assert "cannot be reached" in answer.failure
        assert "secret-path" not in answer.failure


def test_a_certificate_must_be_for_the_name_of_the_address(tmp_path: Path) -> None:
    certificate, key = self_signed(tmp_path, ["hooks.example"])
    tls = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    tls.load_cert_chain(certificate, key)
    trusting = ssl.create_default_context(cafile=str(certificate))

    async def ask(host: str, context: ssl.SSLContext | None) -> WebhookAnswer:
        async with receiving(Receiver(OK), tls) as receiver:

            async def resolve(_host: str, _port: int) -> Sequence[str]:
                return ["127.0.0.1"]

            sender = HttpWebhookSender(LOOPBACK, context, resolve)
            return await sent(sender, f"https://{host}:{receiver.port}/")

    assert asyncio.run(ask("hooks.example", trusting)).failure == ""
    assert "cannot be reached" in asyncio.run(ask("other.example", trusting)).failure
    assert "cannot be reached" in asyncio.run(ask("hooks.example", None)).failure
