"""A small client of /ws/developer for scripts: typed calls over JSON-RPC 2.0, news by subscription.

async with connect("http://127.0.0.1:8080", token) as campus:
    for shuttle in await campus.list_vehicles():
        print(shuttle.name, shuttle.x_m, shuttle.y_m)
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

T = TypeVar("T")
Topic = Literal["vehicles", "rides", "events"]

NEWS_WAITING_MAX = 1000
OPEN_TIMEOUT_S = 10.0


class Shuttle(msgspec.Struct, frozen=True):
    """A vehicle as the live scene shows it; metres in the map frame, REP-103 yaw."""

    vehicle_id: str
    name: str
    seats: int
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    located: bool
    mode: str
    connected: bool
    held: bool
    in_service: bool
    battery_ratio: float
    doors_open: bool
    next_stop: str
    visit_id: str
    people_aboard: int


class Stop(msgspec.Struct, frozen=True):
    stop_id: str
    name: str
    name_en: str
    x_m: float
    y_m: float


class RideSummary(msgspec.Struct, frozen=True):
    ride_id: str
    ride_code: str
    state: str
    from_stop: str
    to_stop: str
    party: int
    vehicle_id: str


class Sent(msgspec.Struct, frozen=True):
    """The visit that the vehicle will make; eta is None while the plan has none."""

    visit_id: str
    plan_version: int
    eta: str | None


class CommandGiven(msgspec.Struct, frozen=True):
    command_id: str
    state: str


class News(msgspec.Struct, frozen=True):
    """Something subscribed to: params as the topic's documentation says."""

    topic: str
    params: dict[str, Any]


class DeveloperError(Exception):
    """The server said no: `number` of JSON-RPC, `code` of the problem where there is one."""

    def __init__(self, number: int, message: str, data: object = None) -> None:
        super().__init__(message)
        self.number, self.message, self.data = number, message, data
        self.code = data.get("code", "") if isinstance(data, dict) else ""


class ConnectionLost(Exception):
    """The server closed the connection; the text says why."""


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
        self._news: asyncio.Queue[News | None] = asyncio.Queue(NEWS_WAITING_MAX)
        self._lost = ""

    async def list_vehicles(self) -> list[Shuttle]:
        return await self._call("list_vehicles", {}, list[Shuttle])

    async def list_stops(self) -> list[Stop]:
        return await self._call("list_stops", {}, list[Stop])

    async def list_rides(self, states: list[str] | None = None, limit: int = 100) -> list[RideSummary]:
        """Newest request first. states: e.g. ["assigned", "aboard"], all when None."""
        return await self._call("list_rides", {"states": states, "limit": limit}, list[RideSummary])

    async def send_to_stop(self, vehicle_id: str, stop_id: str) -> Sent:
        """Have a shuttle visit a stop after what it has promised already. Needs the scope `drive`."""
        return await self._call("send_to_stop", {"vehicle_id": vehicle_id, "stop_id": stop_id}, Sent)

    async def pause(self, vehicle_id: str) -> CommandGiven:
        """Bring a shuttle to a comfortable stand. Needs the scope `drive`."""
        return await self._call("pause", {"vehicle_id": vehicle_id}, CommandGiven)

    async def resume(self, vehicle_id: str) -> CommandGiven:
        """Let a held shuttle drive on. Needs the scope `drive`."""
        return await self._call("resume", {"vehicle_id": vehicle_id}, CommandGiven)

    async def subscribe(self, *topics: Topic) -> list[str]:
        """From now on `news` yields these topics; all that are subscribed come back."""
        return await self._call("subscribe", {"topics": list(topics)}, list[str])

    async def unsubscribe(self, *topics: Topic) -> list[str]:
        return await self._call("unsubscribe", {"topics": list(topics)}, list[str])

    async def news(self) -> AsyncIterator[News]:
        """What was subscribed to, as it comes; the oldest is dropped for who does not read.

        Raises ConnectionLost when the server has gone.
        """
        while (item := await self._news.get()) is not None:
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
        self._tell(None)

    def _take(self, frame: _Frame) -> None:
        if frame.method == "refused":
            self._lost = f"{frame.params.get('code')}: {frame.params.get('detail')}"
        elif frame.method:
            self._tell(News(frame.method, frame.params))
        elif frame.id in self._waiting and not self._waiting[frame.id].done():
            answer = self._waiting[frame.id]
            if frame.error is None:
                answer.set_result(frame.result)
            else:
                answer.set_exception(DeveloperError(frame.error.code, frame.error.message, frame.error.data))

    def _tell(self, item: News | None) -> None:
        if self._news.full():
            self._news.get_nowait()
        self._news.put_nowait(item)


@asynccontextmanager
async def connect(server_url: str, token: str, tls: ssl.SSLContext | None = None) -> AsyncIterator[Campus]:
    """A connection to the server at http(s)://HOST:PORT, with a developer token made in the console.

    tls  for a server with a self-signed certificate: a context that trusts it
    Raises OSError when nobody listens there, ConnectionLost when the token is refused.
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
