"""Live updates over /ws/developer: a snapshot first, then changes; a lost connection is opened again.

async with campus.live("vehicles", "rides") as live:
    async for update in live:
        print(len(live.vehicles), update.snapshot)
"""

import asyncio
import itertools
import random
import ssl
from collections import deque
from collections.abc import AsyncIterator, Iterator
from contextlib import suppress
from types import TracebackType
from typing import Any, Self

import msgspec
from websockets.asyncio.client import ClientConnection
from websockets.asyncio.client import connect as dial
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus

from campusloop_sdk.backoff import pauses
from campusloop_sdk.errors import AnswerUnreadable, ConnectionLost, NotAllowed, RequestRefused
from campusloop_sdk.live_models import (
    UPDATES,
    LiveRide,
    LiveVehicle,
    RidesUpdate,
    Topic,
    Update,
    VehiclesUpdate,
)

OPEN_TIMEOUT_S = 10.0
FIRST_ATTEMPTS = 5
# A snapshot of a large fleet is one frame.
FRAME_BYTES_MAX = 64 * 1024 * 1024


class _Failure(msgspec.Struct, frozen=True):
    code: int
    message: str
    data: Any = None


class _Frame(msgspec.Struct, frozen=True):
    id: int | None = None
    error: _Failure | None = None
    method: str = ""
    params: msgspec.Raw = msgspec.Raw(b"null")


class _Refusal(msgspec.Struct, frozen=True):
    code: str
    detail: str


class Live:
    """One subscription to topics. Iterate over it in one task.

    vehicles, rides  all that there are now, by id, kept up to date by the iteration

    What happens while the connection is lost is not repeated event by event: after it is open again, every
    topic of vehicles or rides begins with a snapshot. The server disconnects a script that reads too slowly;
    it goes on in the same way.
    """

    def __init__(
        self, url: str, token: str, topics: tuple[Topic, ...], tls: ssl.SSLContext | None, rng: random.Random
    ) -> None:
        self.vehicles: dict[str, LiveVehicle] = {}
        self.rides: dict[str, LiveRide] = {}
        self._url, self._headers, self._tls, self._rng = url, {"Authorization": f"Bearer {token}"}, tls, rng
        self._topics: dict[Topic, None] = dict.fromkeys(topics)
        self._numbers = itertools.count(1)
        self._decoder = msgspec.json.Decoder(_Frame)
        self._connection: ClientConnection | None = None
        self._early: deque[Update] = deque()

    async def __aenter__(self) -> Self:
        """Connected and subscribed: what happens from now on is seen. Raises ConnectionLost, NotAllowed."""
        await self._open(itertools.islice(pauses(self._rng), FIRST_ATTEMPTS - 1))
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._connection is not None:
            await self._connection.close()

    async def subscribe(self, *topics: Topic) -> None:
        """These topics too; their snapshots come with the iteration."""
        self._topics.update(dict.fromkeys(topics))
        # Without a connection, the iteration opens the next one, which subscribes to all topics.
        with suppress(ConnectionClosed):
            await self._request("subscribe", topics)

    async def unsubscribe(self, *topics: Topic) -> None:
        for topic in topics:
            self._topics.pop(topic, None)
        with suppress(ConnectionClosed):
            await self._request("unsubscribe", topics)

    async def __aiter__(self) -> AsyncIterator[Update]:
        """Updates in order, without end. Raises NotAllowed when the token is no longer valid."""
        while True:
            yield await self._next()

    # ---------------------------------------------------------------- inside

    async def _next(self) -> Update:
        while not self._early:
            assert self._connection is not None, "use `async with campus.live(...) as live`"
            try:
                data = await self._connection.recv()
            except ConnectionClosed:
                await self._open(pauses(self._rng))
                continue
            self._take(data)
        return self._early.popleft()

    async def _open(self, waits: Iterator[float]) -> None:
        """Connect and subscribe; after each failure wait as long as `waits` says.

        Raises ConnectionLost at the end of `waits`, NotAllowed.
        """
        while True:
            try:
                self._connection = await dial(
                    self._url,
                    additional_headers=self._headers,
                    ssl=self._tls,
                    open_timeout=OPEN_TIMEOUT_S,
                    max_size=FRAME_BYTES_MAX,
                )
                await self._renew(self._connection)
                return
            except (OSError, TimeoutError, InvalidHandshake, ConnectionClosed) as error:
                if isinstance(error, InvalidStatus) and error.response.status_code < 500:
                    text = f"the server answers {error.response.status_code} at {self._url}"
                    raise ConnectionLost(text) from error
                wait_s = next(waits, None)
                if wait_s is None:
                    raise ConnectionLost(f"no connection to {self._url}: {error!r}") from error
            await asyncio.sleep(wait_s)

    async def _renew(self, connection: ClientConnection) -> None:
        """Subscribe and wait for the answer; updates before it are kept."""
        if self._topics:
            number = await self._request("subscribe", tuple(self._topics))
            while self._take(await connection.recv()) != number:
                pass

    async def _request(self, method: str, topics: tuple[Topic, ...]) -> int:
        assert self._connection is not None, "use `async with campus.live(...) as live`"
        number = next(self._numbers)
        request = {"jsonrpc": "2.0", "id": number, "method": method, "params": {"topics": topics}}
        await self._connection.send(msgspec.json.encode(request).decode())
        return number

    def _take(self, data: str | bytes) -> int | None:
        """Keep the update in a frame; the number of the request that it answers. Raises RequestRefused."""
        try:
            frame = self._decoder.decode(data)
            if frame.error is not None:
                raise RequestRefused(str(frame.error.code), frame.error.message)
            if frame.method == "refused":
                refusal = msgspec.json.decode(frame.params, type=_Refusal)
                raise NotAllowed(refusal.code, refusal.detail)
            if frame.method in UPDATES:
                self._keep(msgspec.json.decode(frame.params, type=UPDATES[frame.method]))
        except msgspec.DecodeError as error:
            raise AnswerUnreadable(f"{self._url}: {error}") from error
        return frame.id

    def _keep(self, update: Update) -> None:
        if isinstance(update, VehiclesUpdate):
            if update.snapshot:
                self.vehicles.clear()
            self.vehicles.update({vehicle.vehicle_id: vehicle for vehicle in update.vehicles})
            for vehicle_id in update.gone:
                self.vehicles.pop(vehicle_id, None)
        elif isinstance(update, RidesUpdate):
            if update.snapshot:
                self.rides.clear()
            self.rides.update({ride.ride_id: ride for ride in update.rides})
            for ride_id in update.gone:
                self.rides.pop(ride_id, None)
        self._early.append(update)
