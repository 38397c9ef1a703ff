"""Puts the client's address, as trusted proxies forward it, in the place of the proxy's."""

from collections.abc import Sequence

from starlette.types import ASGIApp, Receive, Scope, Send

from server.addresses import ForwardedHeader, Network, client_of


class ClientAddresses:
    """For requests and websockets. header: the one that the proxies set; the other one is anybody's."""

    def __init__(self, app: ASGIApp, trusted: Sequence[Network], header: ForwardedHeader) -> None:
        self._app, self._trusted, self._header = app, tuple(trusted), header.encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if self._trusted and scope["type"] in ("http", "websocket") and scope.get("client"):
            peer, port = scope["client"]
            client = client_of(peer, self._hops(scope), self._trusted)
            if client != peer:
                scope = {**scope, "client": (client, port)}
        await self._app(scope, receive, send)

    def _hops(self, scope: Scope) -> list[str]:
        lines = [value.decode("latin-1") for name, value in scope["headers"] if name == self._header]
        hops = [hop for line in lines for hop in line.split(",")]
        return hops if self._header == b"x-forwarded-for" else [_for_of(hop) for hop in hops]


def _for_of(hop: str) -> str:
    """The node in the `for=` of one element of `Forwarded` (RFC 7239), "" without one."""
    for pair in hop.split(";"):
        name, _, value = pair.strip().partition("=")
        if name.lower() == "for":
            return value.strip().strip('"')
    return ""
