"""How a session of a vehicle with the server begins, keeps the clocks together, and ends."""

from contract.wire.base import Message
from contract.wire.events import EventLogState
from contract.wire.orders import OrderProgress

PROTOCOL_VERSION = 1
OLDEST_PROTOCOL_VERSION = 1


class Challenge(Message, frozen=True, tag="challenge"):
    """Server, first: sign this nonce. Also the protocol versions it speaks and its send time."""

    nonce: str
    protocol_min: int
    protocol_max: int
    server_ns: int


class Hello(Message, frozen=True, tag="hello"):
    """Vehicle: who I am, what I hold. `signature` is Ed25519 over `signed_hello(...)`, base64."""

    protocol: int
    vehicle_id: str
    boot_id: str
    nonce: str
    signature: str
    software: str
    stack: str
    map_version: str
    vehicle_ns: int
    event_logs: tuple[EventLogState, ...] = ()
    progress: OrderProgress | None = None
    seats: int = 6
    wheelchair_places: int = 0


def signed_hello(nonce: str, vehicle_id: str, boot_id: str, protocol: int) -> bytes:
    """The bytes that a vehicle's key signs; bound to one nonce, so that a copied hello opens nothing."""
    return f"campusloop-hello\n{protocol}\n{nonce}\n{vehicle_id}\n{boot_id}".encode()


class Welcome(Message, frozen=True, tag="welcome"):
    """Server: you are in. Frames of an older epoch are refused from here on."""

    epoch: int
    protocol: int
    server_ns: int
    acknowledged: tuple[EventLogState, ...] = ()


class ClockProbe(Message, frozen=True, tag="clock_probe"):
    vehicle_ns: int


class ClockSample(Message, frozen=True, tag="clock_sample"):
    """Server's answer to a probe; with the arrival stamp the vehicle has offset and round trip."""

    vehicle_ns: int
    server_ns: int


class Goodbye(Message, frozen=True, tag="goodbye"):
    """Server, before it closes: why, as a typed code, and what to do about it."""

    code: str
    detail: str
