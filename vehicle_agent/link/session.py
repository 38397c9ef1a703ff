"""The vehicle's side of the conversation with the server, without I/O: bytes and stamps in, messages out.

The shell around it moves bytes and waits. A lost connection is harmless at any moment: events stay in the log
until they are acknowledged, answers and orders are repeated, and the hello reports the order's progress.
"""

from collections.abc import Callable

import msgspec

from contract.wire.close_reasons import CloseCode
from contract.wire.codec import decode_from_server, encode
from contract.wire.localization_maps import LocalizesBy
from contract.wire.messages import (
    LATER_KINDS,
    PROTOCOL_VERSION,
    CameraPicture,
    Challenge,
    ClockProbe,
    ClockSample,
    Command,
    EventReport,
    EventsAcknowledged,
    Goodbye,
    Grants,
    Hello,
    LocalizationMapPublished,
    MapPublished,
    Message,
    OnboardScene,
    Order,
    OrderAccepted,
    OrderProgress,
    OrderRejected,
    PassengerTap,
    Presence,
    ScansRequested,
    Status,
    Welcome,
    signed_hello,
)
from contract.wire.messages import FleetVehicle as FleetVehicleMessage
from contract.wire.sequence import EventLog, LoggedEvent
from vehicle_agent.link.clock import ClockOffset
from vehicle_agent.signals import FleetVehicle, LinkMessage, LinkState, PedestrianPresence

_SECOND_NS = 1_000_000_000
PROBE_EVERY_NS = 10 * _SECOND_NS
REPEAT_AFTER_NS = 3 * _SECOND_NS
SILENT_AFTER_NS = 25 * _SECOND_NS
KEY_CONFLICT: CloseCode = "key_conflict"

Sign = Callable[[bytes], str]


class Identity(msgspec.Struct, frozen=True):
    """The vehicle's identity, in every hello.

    boot_id      of the process that numbers events
    run_boot_id  of the run that is recorded, "" if that is the same
    understands  later kinds of messages that this agent can read, and act on
    localizes_by, localization_map  the kind of map that scans are compared with, and which; "" for none
    """

    vehicle_id: str
    boot_id: str
    software: str
    stack: str
    map_version: str
    seats: int
    wheelchair_places: int
    run_boot_id: str = ""
    understands: tuple[str, ...] = LATER_KINDS
    localizes_by: LocalizesBy = ""
    localization_map: str = ""


class VehicleSession:
    """One vehicle's conversation over any number of connections.

    is_open    the server has welcomed this connection
    refusal    the server's goodbye, when it closed the last connection with one
    """

    def __init__(
        self, identity: Identity, sign: Sign, log: EventLog, progress: OrderProgress | None = None
    ) -> None:
        self.identity = identity
        self.log = log
        self.progress = progress
        self.is_open = False
        self.epoch = 0
        self.refusal: Goodbye | None = None
        self._sign = sign
        self._clock = ClockOffset()
        self._outgoing: list[bytes] = []
        self._messages: list[LinkMessage] = []
        self._published: MapPublished | None = None
        self._scans: ScansRequested | None = None
        self._published_localization: LocalizationMapPublished | None = None
        self._sent: dict[str, int] = {}
        self._received_ns = 0
        self._probed_ns = 0
        self._progress_ns = 0

    # ------------------------------------------------------------ the shell's side

    def connected(self, now_ns: int) -> None:
        """A new connection is open; the server sends first."""
        self._outgoing.clear()
        self._received_ns = now_ns
        self.refusal = None

    def disconnected(self, now_ns: int) -> None:
        """The connection is lost; unacknowledged events are kept."""
        self._outgoing.clear()
        if self.is_open:
            self.is_open = False
            self._queue_link_state(now_ns)

    def received(self, data: bytes | str, now_ns: int) -> None:
        """Takes one frame. Raises WireError for a frame that is no message: the connection must be closed."""
        self._received_ns = now_ns
        message = decode_from_server(data)
        if isinstance(message, Challenge):
            self._send_hello(message, now_ns)
        elif isinstance(message, Welcome):
            self._welcomed(message, now_ns)
        elif isinstance(message, ClockSample):
            self._clock.add(message.vehicle_ns, message.server_ns, now_ns)
            self._queue_link_state(now_ns)
        elif isinstance(message, EventsAcknowledged):
            self._acknowledged(message, now_ns)
        elif isinstance(message, Goodbye):
            self.refusal = message
            if message.code == KEY_CONFLICT and self.epoch > 0:
                self._hold()
        elif self.is_open and message.epoch == self.epoch:
            if isinstance(message, MapPublished):
                self._published = message
            elif isinstance(message, ScansRequested):
                self._scans = message
            elif isinstance(message, LocalizationMapPublished):
                self._published_localization = message
            else:
                self._queue(message)

    def advance(self, now_ns: int) -> None:
        """Probes the clock and repeats unacknowledged events, when they are due."""
        if not self.is_open:
            return
        if now_ns - self._probed_ns >= PROBE_EVERY_NS:
            self._probe(now_ns)
        if self.log.pending() and now_ns - self._progress_ns >= REPEAT_AFTER_NS:
            self._sent.clear()
            self._send_events(now_ns)

    def is_silent(self, now_ns: int) -> bool:
        """Nothing was received for so long that the connection must be closed."""
        return now_ns - self._received_ns > SILENT_AFTER_NS

    def take_outgoing(self) -> list[bytes]:
        """The frames to send, in order; the caller sends them all or reports the connection lost."""
        outgoing, self._outgoing = self._outgoing, []
        return outgoing

    def take_messages(self) -> list[LinkMessage]:
        """The messages for the vehicle, in order."""
        messages, self._messages = self._messages, []
        return messages

    def take_published_map(self) -> MapPublished | None:
        """The map that the server has announced last, once for each time."""
        published, self._published = self._published, None
        return published

    def take_scan_requests(self) -> ScansRequested | None:
        """The open requests for scans that the server has sent last, once for each time."""
        scans, self._scans = self._scans, None
        return scans

    def take_published_localization_map(self) -> LocalizationMapPublished | None:
        """The localization map that the server has announced last, once for each time."""
        published, self._published_localization = self._published_localization, None
        return published

    # ------------------------------------------------------------ the vehicle's side

    def report(self, status: Status) -> None:
        """Sends a status, if connected; a status is never kept."""
        if self.is_open:
            self._send(msgspec.structs.replace(status, epoch=self.epoch))

    def show(self, scene: OnboardScene | CameraPicture) -> None:
        """Sends a scene or a picture that an operator asked for, if connected; neither is ever kept."""
        if self.is_open:
            self._send(msgspec.structs.replace(scene, epoch=self.epoch))

    def answer(self, answer: OrderAccepted | OrderRejected) -> None:
        """Sends an answer to an order, if connected; the mission's memory must be on disk.

        A lost answer needs no repeat: the server repeats the order after the next hello.
        """
        if self.is_open:
            self._send(msgspec.structs.replace(answer, epoch=self.epoch))

    def send_new_events(self, now_ns: int) -> None:
        """Sends the new events of the log, which are on disk already."""
        if self.is_open:
            self._send_events(now_ns)

    # ------------------------------------------------------------ inside

    def _send_hello(self, challenge: Challenge, now_ns: int) -> None:
        identity = self.identity
        protocol = min(PROTOCOL_VERSION, challenge.protocol_max)
        text = signed_hello(challenge.nonce, identity.vehicle_id, identity.boot_id, protocol)
        hello = Hello(
            protocol=protocol,
            vehicle_id=identity.vehicle_id,
            boot_id=identity.boot_id,
            nonce=challenge.nonce,
            signature=self._sign(text),
            software=identity.software,
            stack=identity.stack,
            map_version=identity.map_version,
            vehicle_ns=now_ns,
            event_logs=self.log.logs(),
            progress=self.progress,
            seats=identity.seats,
            wheelchair_places=identity.wheelchair_places,
            understands=identity.understands,
            run_boot_id=identity.run_boot_id,
            localizes_by=identity.localizes_by,
            localization_map=identity.localization_map,
        )
        self._send(hello)

    def _welcomed(self, welcome: Welcome, now_ns: int) -> None:
        self.is_open = True
        self.epoch = welcome.epoch
        for entry in welcome.acknowledged:
            self.log.acknowledge(entry.boot_id, entry.first_unacknowledged)
        self._sent.clear()
        self._clock.restart(welcome.server_ns, now_ns)
        self._probe(now_ns)
        self._queue_link_state(now_ns)
        self._send_events(now_ns)

    def _acknowledged(self, message: EventsAcknowledged, now_ns: int) -> None:
        if self.log.acknowledge(message.boot_id, message.next_sequence) > 0:
            self._progress_ns = now_ns
        else:
            # The server names the event that it expects: everything from there on is repeated.
            self._sent[message.boot_id] = min(
                message.next_sequence, self._sent.get(message.boot_id, message.next_sequence)
            )
            if now_ns - self._progress_ns >= REPEAT_AFTER_NS:
                self._send_events(now_ns)

    def _send_events(self, now_ns: int) -> None:
        for event in self.log.pending():
            if event.sequence >= self._sent.get(event.boot_id, 0):
                self._send(_report(event, self.epoch))
                self._sent[event.boot_id] = event.sequence + 1
                self._progress_ns = now_ns

    def _probe(self, now_ns: int) -> None:
        self._probed_ns = now_ns
        self._send(ClockProbe(now_ns))

    def _queue(
        self, message: Order | Grants | Command | PassengerTap | Presence | FleetVehicleMessage
    ) -> None:
        """Queue a message for the mission, with the server's stamps in the vehicle's clock."""
        if isinstance(message, Presence):
            detected_ns = message.server_ns - self._clock.offset_ns
            self._messages.append(
                PedestrianPresence(detected_ns, message.area_id, message.count, by_server=True)
            )
        elif isinstance(message, FleetVehicleMessage):
            self._messages.append(
                FleetVehicle(
                    message.server_ns - self._clock.offset_ns,
                    message.vehicle_id,
                    message.pose_map,
                    message.speed_mps,
                )
            )
        else:
            self._messages.append(message)

    def _hold(self) -> None:
        """Stop and stand until an operator has settled whose key it is."""
        command_id = f"{KEY_CONFLICT}-{self.identity.boot_id}"
        self._queue(Command(self.epoch, command_id, "hold", "another agent uses the key of this vehicle"))

    def _queue_link_state(self, now_ns: int) -> None:
        self._messages.append(LinkState(now_ns, self.is_open, self.epoch, self._clock.offset_ns))

    def _send(self, message: Message) -> None:
        self._outgoing.append(encode(message))


def _report(event: LoggedEvent, epoch: int) -> EventReport:
    return EventReport(epoch, event.boot_id, event.sequence, event.stamp_ns, event.body)
