"""/ws/board/STOP: the board of a stop, whenever it changes. It names no rider and needs no token."""

import asyncio
from urllib.parse import urlsplit, urlunsplit

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketDisconnect

from server.api.campus.boards import BoardView, read_board
from server.api.services import InjectedServices, Services
from server.api.sockets.outgoing import close_number
from server.domain.errors import DomainError
from server.usecases.ports import topics

router = APIRouter()

# Between two readings for one screen; what happens meanwhile is in the next one.
SOONEST_S = 1.0
# Expected times move without any news; a screen that hears nothing for longer asks again by itself.
LATEST_S = 5.0
NOT_SERVED = 4404


@router.websocket("/ws/board/{stop_id}")
async def board_socket(websocket: WebSocket, stop_id: str, services: InjectedServices) -> None:
    """Each message is the answer of `GET /stops/{stop_id}/board`."""
    await websocket.accept()
    news = asyncio.Event()
    loop = asyncio.get_running_loop()
    tasks = [
        loop.create_task(_send_boards(websocket, stop_id, services, news)),
        loop.create_task(_until_gone(websocket)),
        *(loop.create_task(_note_news(services, topic, news)) for topic in _topics(services.campus_id)),
    ]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
    for task in tasks:
        if task.done() and not task.cancelled():
            task.result()


def _topics(campus_id: str) -> tuple[str, ...]:
    return (
        topics.vehicle(campus_id, "*"),
        topics.service(campus_id),
        topics.closures(campus_id),
        topics.announcements(campus_id),
        topics.campus_map(campus_id),
    )


async def _note_news(services: Services, topic: str, news: asyncio.Event) -> None:
    subscription = await services.bus.subscribe(topic)
    try:
        async for _ in subscription:
            news.set()
    finally:
        await subscription.close()


async def _send_boards(websocket: WebSocket, stop_id: str, services: Services, news: asyncio.Event) -> None:
    base_url, told = _page_address(websocket), None
    loop, told_s = asyncio.get_running_loop(), 0.0
    try:
        while True:
            news.clear()
            board = await read_board(services, stop_id, base_url)
            if _differs(board, told) or loop.time() - told_s >= LATEST_S:
                await websocket.send_text(board.model_dump_json())
                told, told_s = board, loop.time()
            await asyncio.sleep(SOONEST_S)
            try:
                async with asyncio.timeout(LATEST_S - SOONEST_S):
                    await news.wait()
            except TimeoutError:
                continue
    except WebSocketDisconnect:
        return
    except DomainError as error:
        await websocket.close(close_number(error, NOT_SERVED), error.code)


def _differs(board: BoardView, told: BoardView | None) -> bool:
    """In more than the time of day, which is also when an open service opens next."""
    if told is None or board.open_now != told.open_now:
        return True
    clock = {"now": board.now} | ({"opens_next": board.opens_next} if board.open_now else {})
    return board != told.model_copy(update=clock)


def _page_address(websocket: WebSocket) -> str:
    """By which the screen reaches us, for the code that it shows."""
    parts = urlsplit(str(websocket.base_url))
    return urlunsplit(parts._replace(scheme=parts.scheme.replace("ws", "http", 1)))


async def _until_gone(websocket: WebSocket) -> None:
    while (await websocket.receive())["type"] != "websocket.disconnect":
        pass
