"""The protocol of one vehicle's connection, without sockets: bytes in, actions out.

    challenged --hello--> checking --key--> opening --welcome--> open --> closed

A session gives one nonce and takes one hello. A frame that breaks the protocol ends it with a typed goodbye.
No event is lost, because events leave the vehicle's outbox only when they are acknowledged.
"""

from typing import Literal

import msgspec

from contract.wire.close_reasons import CloseCode
from contract.wire.codec import MAX_MESSAGE_BYTES, WireError, decode_from_vehicle
from contract.wire.messages import (
    OLDEST_PROTOCOL_VERSION,
    PROTOCOL_VERSION,
    CameraPicture,
    Challenge,
    ClockProbe,
    ClockSample,
    EventLogState,
    EventReport,
    EventsAcknowledged,
    Hello,
    OnboardScene,
    OrderAccepted,
    OrderRejected,
    ServerMessage,
    Status,
    VehicleMessage,
    Welcome,
)
from server.fleet.actions import (
    Action,
    Close,
    FindKey,
    NoteAnswer,
    NotePicture,
    NoteScene,
    NoteStatus,
    OpenSession,
    ReportViolation,
    Send,
    StoreEvent,
)
from server.fleet.hello import HelloClaim, HelloRefused, check_hello, claim_in, verify_signature, violation_of

State = Literal["challenged", "checking", "opening", "open", "closed"]
Actions = tuple[Action, ...]

_VEHICLE_TAGS = frozenset(
    str(kind.__struct_config__.tag)
    for kind in (
        Hello,
        ClockProbe,
        Status,
        OrderAccepted,
        OrderRejected,
        EventReport,
        OnboardScene,
        CameraPicture,
    )
)


_HELLO_TAG = str(Hello.__struct_config__.tag)


class _Tagged(msgspec.Struct):
    type: str


class VehicleSession:
    """Takes frames and the answers to its own actions; every method returns the next actions."""

    __slots__ = (
        "_hello",
        "_nonce",
        "_violation",
        "boot_id",
        "epoch",
        "protocol",
        "state",
        "understands",
        "vehicle_id",
    )

    def __init__(self, nonce: str) -> None:
        self.state: State = "challenged"
        self.vehicle_id = ""
        self.boot_id = ""
        self.epoch = 0
        self.protocol = 0
        self.understands: tuple[str, ...] = ()
        self._nonce = nonce
        self._hello: Hello | HelloClaim | None = None
        self._violation = ""

    def begin(self, server_ns: int) -> Actions:
        challenge = Challenge(self._nonce, OLDEST_PROTOCOL_VERSION, PROTOCOL_VERSION, server_ns)
        return (Send(challenge),)

    def received(self, data: bytes | str, server_ns: int) -> Actions:
        """Handle one frame. No frame makes it raise; a closed session returns no actions."""
        if self.state == "closed":
            return ()
        if len(data) > MAX_MESSAGE_BYTES:
            return self._violated(
                "frame_too_large", f"{len(data)} bytes; at most {MAX_MESSAGE_BYTES} are allowed"
            )
        try:
            message = decode_from_vehicle(data)
        except WireError as error:
            return self._not_understood(data, error)
        if isinstance(message, Hello):
            return self._hello_received(message)
        if self.state != "open":
            return self.close("hello_expected", "the first message must be the signed hello")
        return self._open_received(message, server_ns)

    # ---------------------------------------------------------------- answers to what the session asked

    def key_found(self, public_key: bytes) -> Actions:
        """public_key: the enrolled Ed25519 key, 32 raw bytes."""
        if self.state != "checking" or self._hello is None:
            return ()
        try:
            verify_signature(self._hello, public_key)
        except HelloRefused as refusal:
            return self.close(refusal.code, refusal.detail)
        self.state = "opening"
        if isinstance(self._hello, HelloClaim):
            return self._violated("malformed", self._violation)
        violation = violation_of(self._hello)
        if violation:
            return self._violated("malformed", violation)
        return (OpenSession(self._hello),)

    def welcomed(self, epoch: int, acknowledged: tuple[EventLogState, ...], server_ns: int) -> Actions:
        """The server opened session `epoch`; acknowledged: the next event of each boot."""
        # Also of a session that was closed meanwhile: its end is recorded by its epoch.
        self.epoch = epoch
        if self.state != "opening":
            return ()
        self.state, self._hello = "open", None
        return (Send(Welcome(epoch, self.protocol, server_ns, acknowledged)),)

    def events_stored(self, boot_id: str, next_sequence: int) -> Actions:
        """Acknowledge events. Also the answer to a gap: the vehicle repeats from next_sequence."""
        return self.send(EventsAcknowledged(self.epoch, boot_id, next_sequence))

    def send(self, message: ServerMessage) -> Actions:
        """Send a message; it is dropped unless the session is open (the outbox has it again later)."""
        return (Send(message),) if self.state == "open" else ()

    def close(self, code: CloseCode, detail: str) -> Actions:
        if self.state == "closed":
            return ()
        self.state = "closed"
        return (Close(code, detail),)

    # ---------------------------------------------------------------- frames

    def _violated(self, code: CloseCode, detail: str) -> Actions:
        """End the session. Only a vehicle whose key was verified is reported: anyone can send frames."""
        is_verified = self.state in ("opening", "open")
        report = (ReportViolation(detail),) if is_verified else ()
        return (*report, *self.close(code, detail))

    def _hello_received(self, hello: Hello | HelloClaim) -> Actions:
        if self.state != "challenged":
            return self.close("hello_repeated", "this connection's nonce was used; dial again for a new one")
        try:
            check_hello(hello, self._nonce)
        except HelloRefused as refusal:
            return self.close(refusal.code, refusal.detail)
        self.state = "checking"
        self._hello, self.vehicle_id, self.boot_id = hello, hello.vehicle_id, hello.boot_id
        self.protocol = hello.protocol
        self.understands = hello.understands if isinstance(hello, Hello) else ()
        return (FindKey(hello.vehicle_id),)

    def _open_received(self, message: VehicleMessage, server_ns: int) -> Actions:
        if isinstance(message, ClockProbe):
            return self.send(ClockSample(message.vehicle_ns, server_ns))
        assert not isinstance(message, Hello)
        if message.epoch != self.epoch:
            return self.close("epoch_stale", f"frame of epoch {message.epoch}; this session is {self.epoch}")
        if isinstance(message, Status):
            return (NoteStatus(message),)
        if isinstance(message, OnboardScene):
            return (NoteScene(message),)
        if isinstance(message, CameraPicture):
            return (NotePicture(message),)
        if isinstance(message, EventReport):
            return (StoreEvent(message, server_ns),)
        return (NoteAnswer(message),)

    def _not_understood(self, data: bytes | str, error: WireError) -> Actions:
        tag = _tag_of(data)
        if tag is not None and tag not in _VEHICLE_TAGS:
            return self._violated("unknown_message", f"no vehicle message is called {tag[:40]!r}")
        claim = claim_in(data) if tag == _HELLO_TAG and self.state == "challenged" else None
        if claim is None:
            return self._violated("malformed", error.detail)
        # Its key decides whether it is this vehicle that says so.
        self._violation = error.detail
        return self._hello_received(claim)


def _tag_of(data: bytes | str) -> str | None:
    try:
        return msgspec.json.decode(data, type=_Tagged).type
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None
