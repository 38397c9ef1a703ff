"""Actions of a vehicle session: send, look up, store, close.

Those that come thousands of times a second are named tuples, which are made three times as fast.
"""

from dataclasses import dataclass
from typing import NamedTuple

from contract.wire.close_reasons import CloseCode
from contract.wire.messages import (
    CameraPicture,
    EventReport,
    Hello,
    OnboardScene,
    OrderAccepted,
    OrderRejected,
    ServerMessage,
    Status,
)


class Send(NamedTuple):
    message: ServerMessage


@dataclass(frozen=True, slots=True)
class Close:
    """Say goodbye and close the transport."""

    code: CloseCode
    detail: str


@dataclass(frozen=True, slots=True)
class FindKey:
    """Answer with `key_found`."""

    vehicle_id: str


@dataclass(frozen=True, slots=True)
class OpenSession:
    """The signature of the hello is right. Answer with `welcomed`."""

    hello: Hello


class StoreEvent(NamedTuple):
    """Answer with `events_stored`. received_ns: the server's clock when the frame came"""

    report: EventReport
    received_ns: int


@dataclass(frozen=True, slots=True)
class ReportViolation:
    """The vehicle, whose key has been verified, sent what is no message of this protocol."""

    detail: str


class NoteStatus(NamedTuple):
    status: Status


class NoteScene(NamedTuple):
    scene: OnboardScene


class NotePicture(NamedTuple):
    picture: CameraPicture


@dataclass(frozen=True, slots=True)
class NoteAnswer:
    answer: OrderAccepted | OrderRejected


@dataclass(frozen=True, slots=True)
class PushOutbox:
    """Send what waits for the vehicle."""


Action = (
    Send
    | Close
    | FindKey
    | OpenSession
    | StoreEvent
    | ReportViolation
    | NoteStatus
    | NoteScene
    | NotePicture
    | NoteAnswer
    | PushOutbox
)
