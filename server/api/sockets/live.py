"""/ws/live: the scene, then its changes.

The first frame from the browser is a `Watch`. A slow reader gets fewer, newer
frames: the next one is made only when the one before has been sent.
"""

import asyncio
import math
from datetime import datetime
from typing import Annotated, Literal
from urllib.parse import urlsplit

import msgspec
from fastapi import APIRouter, Depends, WebSocket
from starlette.websockets import WebSocketDisconnect

from server.api.security.access import SESSION_COOKIE, looking_operator
from server.api.services import InjectedServices, Services
from server.api.sockets.outgoing import close_number
from server.domain.errors import DomainError, StoreFailure
from server.domain.instants import ms_of
from server.live.viewer import EverythingScope, RideScope, Scope, Viewer
from server.usecases.rides.tickets import ride_by_token

router = APIRouter()

WATCH_TIMEOUT_S = 10.0
# Between two messages, however much happens.
SOONEST_S = 0.04
NOT_ALLOWED = 4403
TOO_LATE = 4408
MALFORMED = 4400


class Watch(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """First frame from the browser. ride_token: one's own ride; without it everything, for operators."""

    type: Literal["watch"]
    ride_token: str = ""


class Refused(msgspec.Struct, frozen=True, tag="refused", tag_field="type"):
    """Last message before the server closes: why, and what to do."""

    code: str
    detail: str


async def _same_origin(websocket: WebSocket) -> bool:
    """A page of another site must not watch with this browser's cookie. Scripts send no Origin."""
    origin = websocket.headers.get("origin")
    return origin is None or urlsplit(origin).netloc == websocket.headers.get("host")


@router.websocket("/ws/live")
async def live_socket(
    websocket: WebSocket, services: InjectedServices, same_origin: Annotated[bool, Depends(_same_origin)]
) -> None:
    await websocket.accept()
    try:
        if not same_origin:
            await _refuse(websocket, NOT_ALLOWED, "other_origin", "open the live view from our own pages")
            return
        scope = await _scope(websocket, services)
        if scope is not None:
            await _serve(websocket, services, scope)
    except WebSocketDisconnect:
        return


async def _scope(websocket: WebSocket, services: Services) -> Scope | None:
    try:
        async with asyncio.timeout(WATCH_TIMEOUT_S):
            watch = msgspec.json.decode(await websocket.receive_text(), type=Watch)
        return await _allowed(websocket, services, watch)
    except TimeoutError:
        await _refuse(websocket, TOO_LATE, "watch_late", 'send {"type":"watch"} first')
    except (msgspec.DecodeError, RecursionError, KeyError) as error:
        await _refuse(websocket, MALFORMED, "malformed", f'the first frame must be a "watch": {error}')
    except DomainError as error:
        await _refuse(websocket, close_number(error, NOT_ALLOWED), error.code, error.detail)
    return None


async def _allowed(websocket: WebSocket, services: Services, watch: Watch) -> Scope:
    if watch.ride_token:
        token = watch.ride_token
        ride = await services.transactions.read(lambda uow: ride_by_token(uow, token))
        return RideScope(ride.ride_id)
    await looking_operator(services, websocket.cookies.get(SESSION_COOKIE))
    return EverythingScope()


async def _serve(websocket: WebSocket, services: Services, scope: Scope) -> None:
    loop = asyncio.get_running_loop()
    works = [_send_scenes(websocket, services, scope), _until_gone(websocket)]
    if isinstance(scope, EverythingScope):
        works.append(_until_signed_out(websocket, services))
    tasks = [loop.create_task(work) for work in works]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
    for task in tasks:
        if task.done() and not task.cancelled():
            task.result()


async def _until_signed_out(websocket: WebSocket, services: Services) -> None:
    async def expiry() -> datetime:
        operator = await looking_operator(services, websocket.cookies.get(SESSION_COOKIE))
        return operator.session.expires_at

    refusal = await services.access.until_refused(expiry)
    await _refuse(websocket, NOT_ALLOWED, refusal.code, refusal.detail)


async def _send_scenes(websocket: WebSocket, services: Services, scope: Scope) -> None:
    viewer, loop = Viewer(scope), asyncio.get_running_loop()
    interval_s = services.settings.live_interval_s
    try:
        async with services.feed.watched() as board:
            while True:
                news = services.feed.news if isinstance(scope, EverythingScope) else None
                message = viewer.next_message(board, ms_of(services.clock.now()))
                if message is not None:
                    await websocket.send_text(services.feed.text.of(message))
                await _until_due(news, _until_next_s(loop.time(), interval_s))
    except StoreFailure as error:
        await _refuse(websocket, close_number(error, NOT_ALLOWED), error.code, error.detail)


async def _until_due(news: asyncio.Event | None, wait_s: float) -> None:
    """Until the next regular message, or soon after news. None: of a passenger, of whom there are many."""
    if news is None or wait_s <= SOONEST_S:
        await asyncio.sleep(wait_s)
        return
    await asyncio.sleep(SOONEST_S)
    try:
        async with asyncio.timeout(wait_s - SOONEST_S):
            await news.wait()
    except TimeoutError:
        return


def _until_next_s(now_s: float, interval_s: float) -> float:
    """All viewers wake at the same moments, the multiples of the interval, and so get the same message."""
    # A timer may fire a rounding error before its moment.
    passed = math.floor(now_s / interval_s + 1e-3)
    return (passed + 1) * interval_s - now_s


async def _until_gone(websocket: WebSocket) -> None:
    while (await websocket.receive())["type"] != "websocket.disconnect":
        pass


async def _refuse(websocket: WebSocket, number: int, code: str, detail: str) -> None:
    await websocket.send_text(msgspec.json.encode(Refused(code, detail)).decode())
    await websocket.close(number, code)
