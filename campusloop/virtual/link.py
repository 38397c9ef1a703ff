"""The link in virtual time: an in-memory pipe in place of the websocket, under the same session."""

from collections.abc import Callable

from campusloop.virtual.conductor import Conductor
from campusloop.virtual.pipes import Pipe, PipeEnd
from contract.wire.codec import WireError
from server.fleet.hub import Hub
from vehicle_agent.link.bridge import LinkBridge

REDIAL_AFTER_NS = 2_000_000_000

# Returns the vehicle's end of a new connection to the server, or None while the server is down.
Dial = Callable[[], PipeEnd | None]


class VirtualLink:
    """Dials, moves bytes in both directions once a step, and dials again after a disconnection."""

    def __init__(self, bridge: LinkBridge, dial: Dial) -> None:
        self._session = bridge.session
        self._dial = dial
        self._end: PipeEnd | None = None
        self._received: list[bytes] = []
        self._closed = False
        self._redial_ns = 0

    def step(self, now_ns: int) -> None:
        if self._end is None:
            if now_ns >= self._redial_ns:
                self._connect(now_ns)
            return
        received, self._received = self._received, []
        for data in received:
            try:
                self._session.received(data, now_ns)
            except WireError as error:
                self._end.close(error.detail)
                self._closed = True
                break
        self._session.advance(now_ns)
        for frame in self._session.take_outgoing():
            self._end.send(frame)
        if self._session.is_silent(now_ns):
            self._end.close("no message received")
            self._closed = True
        if self._closed:
            self._disconnect(now_ns)

    def drop(self) -> None:
        """The vehicle disappears without a goodbye; the server notices the closed pipe."""
        if self._end is not None:
            self._end.close("reset")
            self._end.on_message = lambda _data: None
            self._end = None

    def _connect(self, now_ns: int) -> None:
        end = self._dial()
        self._redial_ns = now_ns + REDIAL_AFTER_NS
        if end is None:
            return
        self._end, self._closed, self._received = end, False, []
        end.on_message = self._on_message
        end.on_close = self._on_close
        self._session.connected(now_ns)

    def _on_message(self, data: bytes) -> None:
        self._received.append(data)

    def _on_close(self, _reason: str) -> None:
        self._closed = True

    def _disconnect(self, now_ns: int) -> None:
        self._end = None
        self._redial_ns = now_ns + REDIAL_AFTER_NS
        self._session.disconnected(now_ns)


class PipeTransport:
    """The server's end of a pipe as the hub's transport."""

    def __init__(self, end: PipeEnd) -> None:
        self._end = end

    def send(self, data: bytes) -> None:
        self._end.send(data)

    def close(self, code: int, reason: str) -> None:
        self._end.close(f"{code} {reason}")


class VirtualNetwork:
    """The network between vehicles and one server. It can be cut for a vehicle; the server can be down."""

    def __init__(self, conductor: Conductor) -> None:
        self.hub: Hub | None = None
        self._conductor = conductor
        self._pipes: dict[str, Pipe] = {}
        self._dialled = 0
        self._dead: set[str] = set()

    def dialler(self, vehicle_id: str) -> Dial:
        def dial() -> PipeEnd | None:
            if self.hub is None or vehicle_id in self._dead:
                return None
            self._dialled += 1
            pipe = Pipe(self._conductor, f"{vehicle_id}#{self._dialled}")
            self._pipes[vehicle_id] = pipe
            self._conductor.loop.call_soon(self._answer, pipe)
            return pipe.left

        return dial

    def cut(self, vehicle_id: str) -> None:
        """No network for this vehicle until `restore`."""
        self._dead.add(vehicle_id)
        pipe = self._pipes.pop(vehicle_id, None)
        if pipe is not None:
            pipe.cut()

    def restore(self, vehicle_id: str) -> None:
        self._dead.discard(vehicle_id)

    def _answer(self, pipe: Pipe) -> None:
        assert self.hub is not None
        link = self.hub.attach(PipeTransport(pipe.right))
        pipe.right.on_message = link.received
        pipe.right.on_close = link.closed
