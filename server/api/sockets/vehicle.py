"""/ws/vehicle: moves bytes between a websocket and the hub, and nothing else."""

import asyncio

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketState

from server.api.security.request_origin import address_of
from server.api.services import InjectedServices
from server.api.sockets.frame_stream import Frames, FrameStream, frame_stream
from server.api.sockets.outgoing import OutgoingFrames
from server.fleet.hub import Hub
from server.fleet.link import Link

router = APIRouter()


@router.websocket("/ws/vehicle")
async def vehicle_socket(websocket: WebSocket, services: InjectedServices) -> None:
    await websocket.accept()
    stream = frame_stream(websocket)
    if stream is None:
        await _serve(websocket, services.hub, address_of(websocket))
    else:
        _hand_over(stream, services.hub, address_of(websocket))


def _hand_over(stream: FrameStream, hub: Hub, address: str) -> None:
    """The connection goes on without a task of its own."""
    received = _Received(hub.attach(stream, address))
    received.frames = stream.take_over(received, received.link.closed)
    received.link.go_on_with(received.frames)


class _Received:
    """Hands frames to a link, and reads no more of them while it is full."""

    __slots__ = ("frames", "link")

    def __init__(self, link: Link) -> None:
        self.link = link
        self.frames: Frames | None = None

    def __call__(self, data: bytes) -> None:
        self.link.received(data)
        if self.link.is_full and self.frames is not None:
            self.frames.pause()
            self.link.when_ready(self.frames.resume)


async def _serve(websocket: WebSocket, hub: Hub, address: str) -> None:
    outgoing = OutgoingFrames(websocket)
    link = hub.attach(outgoing, address)
    loop = asyncio.get_running_loop()
    both = (loop.create_task(outgoing.run()), loop.create_task(_receive(websocket, link)))
    try:
        # A link that can send no more is of no use: either end ends both.
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
    finally:
        link.closed("connection lost")
        for task in both:
            task.cancel()
    for task in both:
        if task.done() and not task.cancelled():
            task.result()


async def _receive(websocket: WebSocket, link: Link) -> None:
    while websocket.application_state is WebSocketState.CONNECTED:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            return
        data: bytes | str = message.get("bytes") or message.get("text") or b""
        link.received(data)
        await _until_ready(link)


async def _until_ready(link: Link) -> None:
    if link.is_full:
        ready = asyncio.Event()
        link.when_ready(ready.set)
        await ready.wait()
