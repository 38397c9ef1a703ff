"""Refuses requests for other host names.

Against DNS rebinding: a page of another site whose name suddenly points to this server's address.
"""

from collections.abc import Sequence
from http import HTTPStatus

from starlette.types import ASGIApp, Receive, Scope, Send

from server.addresses import host_of
from server.api.problems import http_problem

LOOPBACK_NAMES = ("localhost", "127.0.0.1", "::1")


class HostCheck:
    """hosts: allowed names, `*.example.org` for all below one; loopback's are always allowed."""

    def __init__(self, app: ASGIApp, hosts: Sequence[str]) -> None:
        self._app = app
        self._names = {*LOOPBACK_NAMES, *(name for name in hosts if not name.startswith("*."))}
        self._endings = tuple(name[1:] for name in hosts if name.startswith("*."))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan" or self._allows(scope):
            await self._app(scope, receive, send)
        elif scope["type"] == "http":
            refusal = http_problem(HTTPStatus.MISDIRECTED_REQUEST, "this server has another name")
            await refusal(scope, receive, send)
        else:
            # Before it is accepted: the handshake is answered with 403.
            await send({"type": "websocket.close", "code": 1008, "reason": ""})

    def _allows(self, scope: Scope) -> bool:
        headers = [value.decode("latin-1") for name, value in scope["headers"] if name == b"host"]
        if len(headers) != 1:
            return False
        host = host_of(headers[0])
        return host in self._names or (bool(self._endings) and host.endswith(self._endings))
