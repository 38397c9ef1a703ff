"""Addresses of clients and names of hosts: how they are written, and who shares a budget."""

from collections.abc import Iterable, Sequence
from ipaddress import IPv4Address, IPv4Network, IPv6Address, IPv6Network, ip_address, ip_network
from typing import Literal

Address = IPv4Address | IPv6Address
Network = IPv4Network | IPv6Network
ForwardedHeader = Literal["x-forwarded-for", "forwarded"]

# What one customer of a provider gets at least: any of its addresses is the same sender.
IPV6_PREFIX = 64
HOPS_MAX = 32
LOOPBACK: tuple[Network, ...] = (ip_network("127.0.0.0/8"), ip_network("::1/128"))


def networks_of(text: str) -> tuple[Network, ...]:
    """The networks in a list with commas, e.g. `127.0.0.1, 10.0.0.0/8, fd00::/8`. Raises ValueError."""
    return tuple(ip_network(part.strip()) for part in text.split(",") if part.strip())


def address_of(text: str) -> Address | None:
    """The address in `192.0.2.7`, `192.0.2.7:80`, `[2001:db8::1]:80`; None for anything else.

    An IPv4 address that is written as an IPv6 one is the IPv4 address.
    """
    text = text.strip()
    if text.startswith("["):
        text = text[1:].partition("]")[0]
    elif text.count(":") == 1:
        text = text.partition(":")[0]
    try:
        address = ip_address(text.partition("%")[0])
    except ValueError:
        return None
    mapped = address.ipv4_mapped if isinstance(address, IPv6Address) else None
    return mapped or address


def budget_of(client: str) -> str:
    """Who shares a budget with this client: its address, or its /64 network for IPv6."""
    address = address_of(client)
    if isinstance(address, IPv6Address):
        return str(IPv6Network((address, IPV6_PREFIX), strict=False))
    return client if address is None else str(address)


def client_of(peer: str, hops: Sequence[str], trusted: Sequence[Network]) -> str:
    """The client's address: the right-most one that no trusted proxy has.

    hops  what the header says, the nearest to the server last. What stands to the left of an untrusted
          address, or of something that is no address, is the sender's invention.
    """
    client = peer
    for hop in reversed(hops[-HOPS_MAX:]):
        if not is_in(client, trusted):
            break
        address = address_of(hop)
        if address is None:
            break
        client = str(address)
    return client


def is_in(client: str, networks: Iterable[Network]) -> bool:
    address = address_of(client)
    return address is not None and any(address in network for network in networks)


def hosts_of(text: str) -> tuple[str, ...]:
    """The names in a list with commas, e.g. `shuttle.example.org, *.example.net`. Raises ValueError."""
    names = tuple(part.strip().lower() for part in text.split(",") if part.strip())
    for name in names:
        if "/" in name or "*" in name.removeprefix("*.") or name == "*.":
            raise ValueError(f"{name!r} is no host name; give names such as example.org or *.example.org")
    return names


def host_of(header: str) -> str:
    """The name or address in a Host header, without the port."""
    header = header.strip().lower()
    if header.startswith("["):
        return header[1:].partition("]")[0]
    return header.partition(":")[0].rstrip(".")
