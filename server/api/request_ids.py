"""An id for every request and every websocket: in the answer, in problem details, in each line of the log."""

import re
from collections.abc import Sequence
from contextvars import Token
from typing import Any

import structlog
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.usecases.ports.clock_and_ids import Ids

REQUEST_HEADER = "X-Request-Id"
CONNECTION_HEADER = "X-Connection-Id"
_SAFE = re.compile(r"[A-Za-z0-9._~:+/=@-]{1,64}")


def current_request_id() -> str:
    """The id of the request that this code answers; empty outside of requests."""
    return str(structlog.contextvars.get_contextvars().get("request_id", ""))


class RequestIds:
    """A client's own id is taken over if it is 1 to 64 safe characters, else the request gets a new one."""

    def __init__(self, app: ASGIApp, ids: Ids) -> None:
        self._app, self._ids = app, ids

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            name, given = REQUEST_HEADER, _given(scope["headers"])
            bound = {"request_id": given or self._ids.new_id("request")}
        elif scope["type"] == "websocket":
            name = CONNECTION_HEADER
            bound = {"connection_id": self._ids.new_id("connection")}
        else:
            await self._app(scope, receive, send)
            return
        (value,) = bound.values()
        header = (name.lower().encode("ascii"), value.encode("ascii"))

        async def send_with_id(message: Message) -> None:
            if message["type"] in ("http.response.start", "websocket.accept"):
                message = {**message, "headers": [*message.get("headers", ()), header]}
            await send(message)

        before: dict[str, Token[Any]] = dict(structlog.contextvars.bind_contextvars(**bound))
        await self._app(scope, receive, send_with_id)
        # Not after an error: outside of this layer it is logged and answered with this id, and then the
        # request's task ends.
        structlog.contextvars.reset_contextvars(**before)


def _given(headers: Sequence[tuple[bytes, bytes]]) -> str:
    """The client's own id; empty if there is none that is safe to log."""
    name = REQUEST_HEADER.lower().encode("ascii")
    values = [value.decode("latin-1") for key, value in headers if key == name]
    return values[0] if len(values) == 1 and _SAFE.fullmatch(values[0]) else ""
