"""Frames on their way to one websocket: sent by one task, bounded, closed in order."""

import asyncio

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from contract.wire.close_reasons import close_reason
from server.domain.errors import DomainError, StoreFailure

FRAMES_WAITING_MAX = 1000
# RFC 6455 and the IANA registry of close codes: the server cannot serve now.
TRY_AGAIN_LATER = 1013


def close_number(error: DomainError, not_allowed: int) -> int:
    """The websocket close code after a refusal: not_allowed, unless it was the database that failed."""
    return TRY_AGAIN_LATER if isinstance(error, StoreFailure) else not_allowed


class OutgoingFrames:
    """The `Transport` of a hub link over a websocket. `send` and `close` return at once."""

    def __init__(self, websocket: WebSocket, frames_max: int = FRAMES_WAITING_MAX) -> None:
        self._websocket = websocket
        self._frames: asyncio.Queue[bytes | tuple[int, str]] = asyncio.Queue()
        self._frames_max = frames_max
        self._closing = False

    def send(self, data: bytes) -> None:
        """A peer that does not read is closed with `too_slow` instead of filling our memory."""
        if self._closing:
            return
        if self._frames.qsize() >= self._frames_max:
            row = close_reason("too_slow")
            self.close(row.number, row.code)
            return
        self._frames.put_nowait(data)

    def close(self, code: int, reason: str) -> None:
        if not self._closing:
            self._closing = True
            self._frames.put_nowait((code, reason))

    async def run(self) -> None:
        """Until closed from here or there."""
        try:
            while True:
                frame = await self._frames.get()
                if isinstance(frame, tuple):
                    await self._close(*frame)
                    return
                await self._websocket.send_text(frame.decode())
        except WebSocketDisconnect:
            return

    async def _close(self, code: int, reason: str) -> None:
        if self._websocket.application_state is WebSocketState.CONNECTED:
            await self._websocket.close(code, reason)
