"""Enters how long every HTTP request took."""

import asyncio

from prometheus_client import Histogram
from starlette.types import ASGIApp, Message, Receive, Scope, Send

# Methods are words of the client: what is none of these would be a label of its own.
_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})


class RequestDurations:
    def __init__(self, app: ASGIApp, requests: Histogram) -> None:
        self._app, self._requests = app, requests

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        loop = asyncio.get_running_loop()
        begun_s, status = loop.time(), 500

        async def send_noting(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
            await send(message)

        try:
            await self._app(scope, receive, send_noting)
        finally:
            method = scope["method"] if scope["method"] in _METHODS else "other"
            # A path holds the secrets of rides: only the route's template is a label.
            route = getattr(scope.get("route"), "path", "pages")
            self._requests.labels(method, route, str(status)).observe(loop.time() - begun_s)
