"""The wire between simulated vehicles and a real server: websockets, which may be cut."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from campusloop.simulation.schedule import VehicleEnd

_OPEN_WITHIN_S = 10.0
_BYTES_MAX = 16 * 1024 * 1024


@dataclass
class RealEnd:
    """The vehicle's end. Frames are sent in order by a task of its own."""

    frames: "asyncio.Queue[bytes | None]" = field(default_factory=asyncio.Queue)
    _on_message: Callable[[bytes], None] | None = None
    _on_close: Callable[[str], None] | None = None
    _is_open: bool = True

    def listen(self, on_message: Callable[[bytes], None], on_close: Callable[[str], None]) -> None:
        self._on_message, self._on_close = on_message, on_close

    def send(self, data: bytes) -> None:
        if self._is_open:
            self.frames.put_nowait(data)

    def close(self, code: int, reason: str) -> None:
        if self._is_open:
            self._is_open = False
            self.frames.put_nowait(None)

    def arrived(self, data: bytes) -> None:
        if self._is_open and self._on_message is not None:
            self._on_message(data)

    def ended(self, reason: str) -> None:
        if self._is_open:
            self._is_open = False
            if self._on_close is not None:
                self._on_close(reason)


class RealNetwork:
    """`campusloop.simulation.schedule.Dialler` over websockets. dials: how often a vehicle has dialled."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._tasks: set[asyncio.Task[None]] = set()
        self._sockets: dict[str, ClientConnection] = {}
        self.dials = 0

    def dial(self, vehicle_id: str, opened: Callable[[VehicleEnd | None], None]) -> None:
        self.dials += 1
        task = asyncio.get_running_loop().create_task(self._hold(vehicle_id, opened))
        self._tasks.add(task)
        task.add_done_callback(self._done)

    def cut(self, vehicle_id: str) -> bool:
        """Without a farewell; the vehicle dials again. False if it has no connection."""
        socket = self._sockets.get(vehicle_id)
        if socket is None:
            return False
        socket.transport.abort()
        return True

    async def close(self) -> None:
        tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _done(self, task: "asyncio.Task[None]") -> None:
        """What a vehicle's own code raises is a violation at the end: the loop's handler is told."""
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            context = {"message": "a vehicle's connection failed", "exception": error}
            asyncio.get_running_loop().call_exception_handler(context)

    async def _hold(self, vehicle_id: str, opened: Callable[[VehicleEnd | None], None]) -> None:
        try:
            socket = await connect(
                self._url, open_timeout=_OPEN_WITHIN_S, proxy=None, max_size=_BYTES_MAX, max_queue=None
            )
        except (OSError, TimeoutError, InvalidHandshake, EOFError):
            opened(None)
            return
        self._sockets[vehicle_id] = socket
        end = RealEnd()
        opened(end)
        sending = asyncio.create_task(_send(socket, end))
        try:
            async for data in socket:
                end.arrived(data.encode() if isinstance(data, str) else data)
            end.ended("closed by the server")
        except ConnectionClosed as error:
            end.ended(str(error))
        finally:
            sending.cancel()
            if self._sockets.get(vehicle_id) is socket:
                del self._sockets[vehicle_id]
            socket.transport.abort()


async def _send(socket: ClientConnection, end: RealEnd) -> None:
    while (frame := await end.frames.get()) is not None:
        try:
            await socket.send(frame.decode())
        except ConnectionClosed:
            return
    await socket.close()
