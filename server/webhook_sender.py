"""Sends webhook messages by HTTP, to public addresses only: a webhook must not reach into our own network."""

import asyncio
import socket
import ssl
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from ipaddress import IPv4Address, IPv6Address, ip_address, ip_network

import httpcore

from server.addresses import Address, Network
from server.usecases.ports.webhooks import WebhookAnswer

ATTEMPT_S_MAX = 10.0
CONNECTIONS_MAX = 32
CONNECTIONS_IDLE_MAX = 4
# IPv6 addresses that stand for an IPv4 address which a translator reaches.
_TRANSLATED = (ip_network("64:ff9b::/96"), ip_network("64:ff9b:1::/48"))

Resolve = Callable[[str, int], Awaitable[Sequence[str]]]


class AddressRefused(Exception):
    """The name leads to an address that webhooks may not reach."""


class HttpWebhookSender:
    """allowed: private networks that webhooks may lead into; only these are reached without TLS.

    Redirects are not followed, and of the answer only the status is read.
    """

    def __init__(
        self,
        allowed: Sequence[Network] = (),
        tls: ssl.SSLContext | None = None,
        resolve: Resolve | None = None,
    ) -> None:
        tls, resolve = tls or ssl.create_default_context(), resolve or _resolve
        self._pools = {
            "https": _pool(tls, _GuardedNetwork(allowed, resolve, may_be_public=True)),
            "http": _pool(tls, _GuardedNetwork(allowed, resolve, may_be_public=False)),
        }

    async def send(self, url: str, headers: Mapping[str, str], body: bytes) -> WebhookAnswer:
        pool = self._pools[url.partition(":")[0]]
        sent = {"content-type": "application/json", "user-agent": "Campusloop-Webhooks/1", **headers}
        try:
            async with (
                asyncio.timeout(ATTEMPT_S_MAX),
                pool.stream("POST", url, headers=list(sent.items()), content=body) as answer,
            ):
                return WebhookAnswer(answer.status)
        except TimeoutError:
            return WebhookAnswer(0, f"no answer within {ATTEMPT_S_MAX:g} s")
        except AddressRefused as error:
            return WebhookAnswer(0, str(error))
        except (
            httpcore.NetworkError,
            httpcore.TimeoutException,
            httpcore.ProtocolError,
            OSError,
        ) as error:
            return WebhookAnswer(0, f"it cannot be reached ({type(error).__name__}: {error})")

    async def close(self) -> None:
        for pool in self._pools.values():
            await pool.aclose()


def is_public(address: Address) -> bool:
    """Anyone can reach it: not loopback, private, link-local, multicast, or such an address translated."""
    if isinstance(address, IPv6Address):
        inner = _embedded(address)
        if inner is not None:
            return is_public(inner)
    return address.is_global and not (address.is_multicast or address.is_reserved or address.is_unspecified)


def _embedded(address: IPv6Address) -> IPv4Address | None:
    if address.ipv4_mapped is not None:
        return address.ipv4_mapped
    if address.sixtofour is not None:
        return address.sixtofour
    if address.teredo is not None:
        return address.teredo[1]
    if any(address in network for network in _TRANSLATED):
        return IPv4Address(int(address) & 0xFFFFFFFF)
    return None


class _GuardedNetwork(httpcore.AsyncNetworkBackend):
    """Resolves a name once, checks all its addresses, and connects to one of them."""

    def __init__(self, allowed: Sequence[Network], resolve: Resolve, may_be_public: bool) -> None:
        self._allowed, self._resolve, self._may_be_public = tuple(allowed), resolve, may_be_public
        self._inner = httpcore.AnyIOBackend()

    async def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,  # noqa: ASYNC109 - the interface of httpcore
        local_address: str | None = None,
        socket_options: Iterable[httpcore.SOCKET_OPTION] | None = None,
    ) -> httpcore.AsyncNetworkStream:
        addresses = [ip_address(text.partition("%")[0]) for text in await self._resolve(host, port)]
        if not addresses:
            raise AddressRefused("its name has no address")
        if not all(self._may_reach(address) for address in addresses):
            raise AddressRefused("its name leads to an address that webhooks may not reach")
        return await self._inner.connect_tcp(str(addresses[0]), port, timeout, local_address, socket_options)

    async def connect_unix_socket(
        self,
        path: str,
        timeout: float | None = None,  # noqa: ASYNC109 - the interface of httpcore
        socket_options: Iterable[httpcore.SOCKET_OPTION] | None = None,
    ) -> httpcore.AsyncNetworkStream:
        raise AddressRefused("webhooks do not use local sockets")

    async def sleep(self, seconds: float) -> None:
        await asyncio.sleep(seconds)

    def _may_reach(self, address: Address) -> bool:
        plain = (isinstance(address, IPv6Address) and address.ipv4_mapped) or address
        if any(plain in network for network in self._allowed if network.version == plain.version):
            return True
        return self._may_be_public and is_public(address)


async def _resolve(host: str, port: int) -> Sequence[str]:
    found = await asyncio.get_running_loop().getaddrinfo(host, port, type=socket.SOCK_STREAM)
    return [str(address[0]) for *_, address in found]


def _pool(tls: ssl.SSLContext, network: httpcore.AsyncNetworkBackend) -> httpcore.AsyncConnectionPool:
    return httpcore.AsyncConnectionPool(
        ssl_context=tls,
        max_connections=CONNECTIONS_MAX,
        max_keepalive_connections=CONNECTIONS_IDLE_MAX,
        network_backend=network,
    )
