"""/ws/infrastructure: cameras at crossings report presence, opened with `Authorization: Bearer TOKEN`.

The token needs the scope `infrastructure` and is checked again for every frame, as on /ws/developer.
"""

import msgspec
from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from contract.wire.codec import encode
from contract.wire.messages import PresenceRefused, PresenceReport
from server.api.security.bearer import bearer_of
from server.api.services import InjectedServices, Services
from server.domain.errors import AreaUnknown, CampusUnknown, DomainError, ScopeMissing, TokenInvalid
from server.usecases.record import identity

router = APIRouter()

NOT_ALLOWED = 4401
FRAME_BYTES_MAX = 2_000

_decoder = msgspec.json.Decoder(PresenceReport)


@router.websocket("/ws/infrastructure")
async def infrastructure_socket(websocket: WebSocket, services: InjectedServices) -> None:
    await websocket.accept()
    secret = bearer_of(websocket)
    try:
        await _check(services, secret)
        while True:
            message = await websocket.receive()
            if message["type"] == "websocket.disconnect":
                return
            data: bytes | str = message.get("text") or message.get("bytes") or b""
            await _check(services, secret)
            refused = await _accepted(services, data)
            if refused is not None:
                await websocket.send_text(encode(refused).decode())
    except (TokenInvalid, ScopeMissing) as error:
        await websocket.send_text(encode(_refusal(error)).decode())
        await websocket.close(NOT_ALLOWED, error.code)
    except WebSocketDisconnect:
        return


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


async def _check(services: Services, secret: str) -> None:
    """Raises TokenInvalid, ScopeMissing."""
    await services.transactions.read(lambda uow: identity.developer_of(uow, secret, "infrastructure"))


def _refusal(error: DomainError) -> PresenceRefused:
    return PresenceRefused(error.code, error.detail)
