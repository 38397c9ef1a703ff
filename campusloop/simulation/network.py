"""The network: vehicles dial the present server, people ask it; faults lose what is under way."""

import asyncio
from collections.abc import Callable

import httpx

from campusloop.simulation.process.service_process import ServiceProcess
from campusloop.simulation.timeline import Timeline
from campusloop.simulation.wire import Connection, End, PathState

DIAL_S = (0.02, 0.1)
REQUEST_S = (0.005, 0.05)


class Network:
    """service: the present server process, None while there is none."""

    def __init__(self, timeline: Timeline) -> None:
        self.service: ServiceProcess | None = None
        self.paths: dict[str, PathState] = {}
        self._timeline = timeline
        self._rng = timeline.rng("network")
        self._connections: dict[str, Connection] = {}

    # ---------------------------------------------------------------- vehicles

    def path(self, vehicle_id: str) -> PathState:
        return self.paths.setdefault(vehicle_id, PathState())

    def dial(self, vehicle_id: str, opened: Callable[[End | None], None]) -> None:
        """Calls `opened` with the vehicle's end of a new connection, or with None if it cannot be made."""
        self._timeline.after(self._rng.uniform(*DIAL_S), lambda: self._open(vehicle_id, opened))

    def cut(self, vehicle_id: str) -> None:
        """The vehicle's connection is cut; it may dial at once."""
        connection = self._connections.get(vehicle_id)
        if connection is not None:
            connection.cut()

    def half_close(self, vehicle_id: str) -> None:
        connection = self._connections.get(vehicle_id)
        if connection is not None:
            connection.half_close()

    def lose_service(self) -> None:
        """The server process has ended: its sockets are closed."""
        self.service = None
        for vehicle_id in self._connections:
            self.cut(vehicle_id)
        self._connections = {}

    def _open(self, vehicle_id: str, opened: Callable[[End | None], None]) -> None:
        path = self.path(vehicle_id)
        service = self.service
        if service is None or service.is_over or not path.is_up:
            opened(None)
            return
        connection = Connection(self._timeline, path, self._rng)
        self._connections[vehicle_id] = connection
        opened(connection.vehicle)
        service.loop.call_soon(_attach, service, connection)


def _attach(service: ServiceProcess, connection: Connection) -> None:
    link = service.services.hub.attach(connection.server)
    connection.server.on_message = link.received
    connection.server.on_close = link.closed


class PeopleTransport(httpx.AsyncBaseTransport):
    """Requests of people, from their event loop to the server's; an answer may be lost on the way.

    lost_ratio  this share of the answers does not arrive, though the server has done its work
    """

    def __init__(self, network: Network, timeline: Timeline) -> None:
        self.lost_ratio = 0.0
        self.lost = 0
        self._network, self._timeline = network, timeline
        self._rng = timeline.rng("people's network")

    async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
        await asyncio.sleep(self._rng.uniform(*REQUEST_S))
        service = self._network.service
        if service is None or service.is_over:
            raise httpx.ConnectError("the server is down", request=request)
        answer: asyncio.Future[httpx.Response] = asyncio.get_running_loop().create_future()
        task = service.loop.create_task(service.handle(request))
        task.add_done_callback(lambda task: self._settle(answer, task, request))
        return await answer

    def _settle(
        self,
        answer: "asyncio.Future[httpx.Response]",
        task: "asyncio.Task[httpx.Response]",
        request: httpx.Request,
    ) -> None:
        """Runs inside the server's loop: the future's owner is told in its own."""
        if answer.done():
            return
        if task.cancelled():
            answer.set_exception(httpx.ReadError("the server has ended", request=request))
        elif self._rng.random() < self.lost_ratio:
            self.lost += 1
            answer.set_exception(httpx.ReadError("the answer was lost", request=request))
        elif (error := task.exception()) is not None:
            answer.set_exception(httpx.ReadError(f"the server failed: {error!r}", request=request))
        else:
            answer.set_result(task.result())
