"""A client of /ws/developer: typed calls over JSON-RPC 2.0, and notifications by subscription.

async with connect("http://127.0.0.1:8080", token) as campus:
    for shuttle in await campus.list_vehicles():
        print(shuttle.facts.name, shuttle.task.next_stop)
"""

import asyncio
import itertools
import ssl
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any, Literal, TypeVar

import msgspec
from websockets.asyncio.client import ClientConnection
from websockets.asyncio.client import connect as dial
from websockets.exceptions import ConnectionClosed

from campusloop_sdk.errors import ConnectionLost, RequestRefused
from campusloop_sdk.models import CommandReceipt, Notification, RideSummary, SentVisit, Shuttle, Stop

T = TypeVar("T")
Topic = Literal["vehicles", "rides", "events"]

NOTIFICATIONS_WAITING_MAX = 1000
OPEN_TIMEOUT_S = 10.0


class _Failure(msgspec.Struct, frozen=True):
    code: int
    message: str
    data: Any = None


class _Frame(msgspec.Struct, frozen=True):
    id: int | None = None
    result: msgspec.Raw = msgspec.Raw(b"null")
    error: _Failure | None = None
    method: str = ""
    params: dict[str, Any] = {}


class Campus:
    """One connection. Calls may be made from several tasks at once."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self._numbers = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[msgspec.Raw]] = {}
        self._notifications: asyncio.Queue[Notification | None] = asyncio.Queue(NOTIFICATIONS_WAITING_MAX)
        self._lost = ""

    async def list_vehicles(self) -> list[Shuttle]:
        return await self._call("list_vehicles", {}, list[Shuttle])

    async def list_stops(self) -> list[Stop]:
        return await self._call("list_stops", {}, list[Stop])

    async def list_rides(self, states: list[str] | None = None, limit: int = 100) -> list[RideSummary]:
        """Newest request first. states: e.g. ["assigned", "aboard"], all when None."""
        return await self._call("list_rides", {"states": states, "limit": limit}, list[RideSummary])

    async def send_to_stop(self, vehicle_id: str, stop_id: str) -> SentVisit:
        """Make a shuttle visit a stop, within all its promises. Needs the scope `drive`."""
        return await self._call("send_to_stop", {"vehicle_id": vehicle_id, "stop_id": stop_id}, SentVisit)

    async def pause(self, vehicle_id: str) -> CommandReceipt:
        """Bring a shuttle to a comfortable stand. Needs the scope `drive`."""
        return await self._call("pause", {"vehicle_id": vehicle_id}, CommandReceipt)

    async def resume(self, vehicle_id: str) -> CommandReceipt:
        """Release a held shuttle. Needs the scope `drive`."""
        return await self._call("resume", {"vehicle_id": vehicle_id}, CommandReceipt)

    async def subscribe(self, *topics: Topic) -> list[str]:
        """`notifications` yields these topics from now on. Returns all subscribed topics."""
        return await self._call("subscribe", {"topics": list(topics)}, list[str])

    async def unsubscribe(self, *topics: Topic) -> list[str]:
        return await self._call("unsubscribe", {"topics": list(topics)}, list[str])

    async def notifications(self) -> AsyncIterator[Notification]:
        """Messages of the subscribed topics in order of arrival.

        If the script reads too slowly, the oldest are lost. Raises ConnectionLost if the server closes.
        """
        while (item := await self._notifications.get()) is not None:
            yield item
        raise ConnectionLost(self._lost)

    # ---------------------------------------------------------------- inside

    async def _call(self, method: str, params: dict[str, object], kind: type[T]) -> T:
        if self._lost:
            raise ConnectionLost(self._lost)
        number = next(self._numbers)
        answer: asyncio.Future[msgspec.Raw] = asyncio.get_running_loop().create_future()
        self._waiting[number] = answer
        request = {"jsonrpc": "2.0", "id": number, "method": method, "params": params}
        try:
            await self._connection.send(msgspec.json.encode(request).decode())
            return msgspec.json.decode(await answer, type=kind)
        except ConnectionClosed as error:
            raise ConnectionLost(self._lost or str(error)) from error
        finally:
            del self._waiting[number]

    async def _receive(self) -> None:
        decoder = msgspec.json.Decoder(_Frame)
        try:
            async for data in self._connection:
                self._take(decoder.decode(data))
        except ConnectionClosed as error:
            self._lost = self._lost or str(error)
        self._lost = self._lost or "the server closed the connection"
        for answer in self._waiting.values():
            if not answer.done():
                answer.set_exception(ConnectionLost(self._lost))
        self._queue(None)

    def _take(self, frame: _Frame) -> None:
        if frame.method == "refused":
            self._lost = f"{frame.params.get('code')}: {frame.params.get('detail')}"
        elif frame.method:
            self._queue(Notification(frame.method, frame.params))
        elif frame.id in self._waiting and not self._waiting[frame.id].done():
            answer = self._waiting[frame.id]
            if frame.error is None:
                answer.set_result(frame.result)
            else:
                answer.set_exception(RequestRefused(frame.error.code, frame.error.message, frame.error.data))

    def _queue(self, item: Notification | None) -> None:
        if self._notifications.full():
            self._notifications.get_nowait()
        self._notifications.put_nowait(item)


@asynccontextmanager
async def connect(server_url: str, token: str, tls: ssl.SSLContext | None = None) -> AsyncIterator[Campus]:
    """A connection to the server at http(s)://HOST:PORT, with a developer token made in the console.

    tls  for a server with a self-signed certificate: a context that trusts it
    Raises OSError when no server listens there, ConnectionLost when the token is refused.
    """
    url = server_url.rstrip("/").replace("http", "ws", 1) + "/ws/developer"
    headers = {"Authorization": f"Bearer {token}"}
    async with dial(url, additional_headers=headers, ssl=tls, open_timeout=OPEN_TIMEOUT_S) as connection:
        campus = Campus(connection)
        receiving = asyncio.get_running_loop().create_task(campus._receive())
        try:
            yield campus
        finally:
            receiving.cancel()
