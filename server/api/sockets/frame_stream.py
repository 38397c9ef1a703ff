"""Frames of a websocket straight from the connection, where the web server offers it.

ASGI takes a task, a queue and two messages for each frame, which is more than the server does with it. A
server that offers the extension hands each data frame to a function instead (docs/decisions/0015).
"""

from collections.abc import Callable
from typing import Protocol

from starlette.websockets import WebSocket

EXTENSION = "campusloop.frames"


class Frames(Protocol):
    """A websocket whose frames come without ASGI. `send` and `close` return at once."""

    def send(self, data: bytes) -> None:
        """Send a text frame. A peer that does not read is closed with `too_slow`."""
        ...

    def close(self, code: int, reason: str) -> None: ...

    def pause(self) -> None:
        """Read no further frames until `resume`: the peer is slowed down."""
        ...

    def resume(self) -> None: ...


class FrameStream(Protocol):
    """A websocket that has been accepted and is still with its endpoint. What is sent goes out later."""

    def take_over(self, received: Callable[[bytes], None], lost: Callable[[str], None]) -> Frames:
        """From here on each frame goes to `received`, and the end of the connection to `lost`.

        The endpoint may return: the connection stays open.
        """
        ...

    def send(self, data: bytes) -> None: ...

    def close(self, code: int, reason: str) -> None: ...


def frame_stream(websocket: WebSocket) -> FrameStream | None:
    """None where frames come by ASGI only."""
    extensions = websocket.scope.get("extensions") or {}
    stream: FrameStream | None = extensions.get(EXTENSION)
    return stream
