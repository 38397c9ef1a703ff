"""/ws/vehicle: moves bytes between a websocket and the hub, and nothing else."""

import asyncio

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketState

from server.api.services import InjectedServices
from server.api.sockets.outgoing import OutgoingFrames
from server.fleet.link import Link

router = APIRouter()


@router.websocket("/ws/vehicle")
async def vehicle_socket(websocket: WebSocket, services: InjectedServices) -> None:
    await websocket.accept()
    outgoing = OutgoingFrames(websocket)
    link = services.hub.attach(outgoing)
    sender = asyncio.get_running_loop().create_task(outgoing.run())
    try:
        await _receive(websocket, link)
    finally:
        link.closed("connection lost")
        sender.cancel()


async def _receive(websocket: WebSocket, link: Link) -> None:
    while websocket.application_state is WebSocketState.CONNECTED:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            return
        data: bytes | str = message.get("bytes") or message.get("text") or b""
        link.received(data)
        await link.ready()
