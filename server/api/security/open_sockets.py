"""How many websockets one client may have open: behind a proxy all connections are the proxy's."""

from starlette.types import ASGIApp, Receive, Scope, Send

from server.api.security.connection_counts import ConnectionCounts


class OpenSockets:
    """Refuses a client's websockets above a number."""

    def __init__(self, app: ASGIApp, per_client_max: int) -> None:
        self._app, self._counts = app, ConnectionCounts(per_client_max)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "websocket" or not scope.get("client"):
            await self._app(scope, receive, send)
            return
        client = scope["client"][0]
        if not self._counts.opened(client):
            await send({"type": "websocket.close", "code": 1013, "reason": ""})
            return
        try:
            await self._app(scope, receive, send)
        finally:
            self._counts.closed(client)
