"""/ws/infrastructure: cameras at crossings report presence, opened with `Authorization: Bearer TOKEN`.

The token needs the scope `infrastructure`. The connection ends with it.
"""

import asyncio
from datetime import datetime

import msgspec
from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from contract.wire.codec import encode
from contract.wire.messages import PresenceRefused, PresenceReport
from server.api.security.bearer import bearer_of
from server.api.services import InjectedServices, Services
from server.api.sockets.outgoing import close_number
from server.domain.errors import (
    AreaUnknown,
    CampusUnknown,
    DomainError,
    ScopeMissing,
    StoreFailure,
    TokenInvalid,
)
from server.domain.record.identity import DeveloperToken
from server.usecases.record import identity

router = APIRouter()

NOT_ALLOWED = 4401
FRAME_BYTES_MAX = 2_000

_decoder = msgspec.json.Decoder(PresenceReport)


@router.websocket("/ws/infrastructure")
async def infrastructure_socket(websocket: WebSocket, services: InjectedServices) -> None:
    await websocket.accept()
    secret = bearer_of(websocket)

    async def expiry() -> datetime:
        return (await _token(services, secret)).expires_at

    loop = asyncio.get_running_loop()
    receiving = loop.create_task(_receive(websocket, services, secret))
    watching = loop.create_task(services.access.until_refused(expiry))
    try:
        await asyncio.wait((receiving, watching), return_when=asyncio.FIRST_COMPLETED)
        if watching.done():
            await _refuse(websocket, watching.result())
        else:
            receiving.result()
    except (TokenInvalid, ScopeMissing, StoreFailure) as error:
        await _refuse(websocket, error)
    except WebSocketDisconnect:
        return
    finally:
        receiving.cancel()
        watching.cancel()


async def _receive(websocket: WebSocket, services: Services, secret: str) -> None:
    """Until the camera is gone. Raises TokenInvalid, ScopeMissing."""
    while (message := await websocket.receive())["type"] != "websocket.disconnect":
        data: bytes | str = message.get("text") or message.get("bytes") or b""
        await _token(services, secret)
        refused = await _accepted(services, data)
        if refused is not None:
            await websocket.send_text(encode(refused).decode())


async def _refuse(websocket: WebSocket, error: DomainError) -> None:
    await websocket.send_text(encode(_refusal(error)).decode())
    await websocket.close(close_number(error, NOT_ALLOWED), error.code)


async def _accepted(services: Services, data: bytes | str) -> PresenceRefused | None:
    """Pass a report on; None if it was accepted."""
    if len(data) > FRAME_BYTES_MAX:
        return PresenceRefused("malformed", f"a report has at most {FRAME_BYTES_MAX} bytes")
    try:
        report = _decoder.decode(data)
        await services.presence.seen(report)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        return PresenceRefused("malformed", f"{error}; see docs/protocol/infrastructure.asyncapi.yaml")
    except (AreaUnknown, CampusUnknown) as error:
        return _refusal(error)
    return None


async def _token(services: Services, secret: str) -> DeveloperToken:
    """Raises TokenInvalid, ScopeMissing."""
    return await services.transactions.read(lambda uow: identity.developer_of(uow, secret, "infrastructure"))


def _refusal(error: DomainError) -> PresenceRefused:
    return PresenceRefused(error.code, error.detail)
