"""One websocket of the server in virtual time, as an ASGI server would serve it."""

import asyncio
from typing import Any

from tests.server.api.server_under_test import ServerUnderTest

Header = tuple[bytes, bytes]


def bearer(secret: str) -> Header:
    return b"authorization", f"Bearer {secret}".encode()


class OpenSocket:
    """said: every ASGI message of the server, in order."""

    def __init__(self, server: ServerUnderTest, path: str, header: Header) -> None:
        self.server = server
        self.said: list[dict[str, Any]] = []
        self.frames: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.frames.put_nowait({"type": "websocket.connect"})
        scope = {
            "type": "websocket",
            "asgi": {"version": "3.0"},
            "path": path,
            "raw_path": path.encode(),
            "query_string": b"",
            "headers": [header],
            "scheme": "ws",
            "subprotocols": [],
            "client": ("127.0.0.1", 5),
            "server": ("campus.test", 80),
            "http_version": "1.1",
            "root_path": "",
            "state": {},
        }
        self.task = server.conductor.loop.create_task(server.app(scope, self.frames.get, self._sent))
        server.elapse(0.2)

    async def _sent(self, message: Any) -> None:
        self.said.append(dict(message))

    def say(self, text: str, within_s: float = 0.5) -> None:
        """Send a frame and let the server answer."""
        self.frames.put_nowait({"type": "websocket.receive", "text": text})
        self.server.elapse(within_s)

    def leave(self) -> None:
        self.frames.put_nowait({"type": "websocket.disconnect", "code": 1000})
        self.server.elapse(0.1)

    @property
    def texts(self) -> list[str]:
        return [message["text"] for message in self.said if message["type"] == "websocket.send"]

    @property
    def closed(self) -> int | None:
        """The code with which the server closed; None while it is open."""
        return next((m["code"] for m in self.said if m["type"] == "websocket.close"), None)
