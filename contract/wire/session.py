"""How a session of a vehicle with the server begins, keeps the clocks together, and ends."""

from typing import Annotated

import msgspec

from contract.wire.base import Message
from contract.wire.bounds import (
    Count,
    Id,
    LongText,
    Places,
    Proof,
    ProtocolVersion,
    Seats,
    ShortText,
    StampNs,
)
from contract.wire.events import EventLogState
from contract.wire.localization_maps import LocalizesBy
from contract.wire.orders import OrderProgress

# 2: a vehicle takes `MapPublished`.
PROTOCOL_VERSION = 2
OLDEST_PROTOCOL_VERSION = 1
# Boots whose events are not acknowledged yet.
BOOTS_MAX = 1_000
UNDERSTOOD_MAX = 100


class Challenge(Message, frozen=True, tag="challenge"):
    """Server, first: sign this nonce. Also the protocol versions it speaks and its send time."""

    nonce: Proof
    protocol_min: ProtocolVersion
    protocol_max: ProtocolVersion
    server_ns: StampNs


class Hello(Message, frozen=True, tag="hello"):
    """Vehicle: who I am, what I hold. `signature` is Ed25519 over `signed_hello(...)`, base64.

    boot_id      whose numbers the events have
    run_boot_id  under which the vehicle records now: its agent may number events and record in two processes;
                 "" for an agent with one
    localizes_by, localization_map  the kind of map that it compares its scans with, and which version; "" for
                 none. An agent that names a kind takes `LocalizationMapPublished`
    understands  the kinds of `Command` among `LATER_KINDS`, and the tags of later messages, that this agent
                 can read
    """

    protocol: ProtocolVersion
    vehicle_id: Id
    boot_id: Id
    nonce: Proof
    signature: Proof
    software: ShortText
    stack: ShortText
    map_version: ShortText
    vehicle_ns: StampNs
    event_logs: Annotated[tuple[EventLogState, ...], msgspec.Meta(max_length=BOOTS_MAX)] = ()
    progress: OrderProgress | None = None
    seats: Seats = 6
    wheelchair_places: Places = 0
    understands: Annotated[tuple[ShortText, ...], msgspec.Meta(max_length=UNDERSTOOD_MAX)] = ()
    run_boot_id: Id = ""
    localizes_by: LocalizesBy = ""
    localization_map: Id = ""


def signed_hello(nonce: str, vehicle_id: str, boot_id: str, protocol: int) -> bytes:
    """The bytes that a vehicle's key signs; bound to one nonce, so that a copied hello opens nothing."""
    return f"campusloop-hello\n{protocol}\n{nonce}\n{vehicle_id}\n{boot_id}".encode()


class Welcome(Message, frozen=True, tag="welcome"):
    """Server: you are in. Frames of an older epoch are refused from here on."""

    epoch: Count
    protocol: ProtocolVersion
    server_ns: StampNs
    acknowledged: Annotated[tuple[EventLogState, ...], msgspec.Meta(max_length=BOOTS_MAX)] = ()


class ClockProbe(Message, frozen=True, tag="clock_probe"):
    vehicle_ns: StampNs


class ClockSample(Message, frozen=True, tag="clock_sample"):
    """Server's answer to a probe; with the arrival stamp the vehicle has offset and round trip."""

    vehicle_ns: StampNs
    server_ns: StampNs


class Goodbye(Message, frozen=True, tag="goodbye"):
    """Server, before it closes: why, as a typed code, and what to do about it."""

    code: Id
    detail: LongText
