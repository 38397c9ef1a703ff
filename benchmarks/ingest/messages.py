"""What a vehicle of the benchmark says: the wire's own messages, encoded once and numbered when they are
sent.

Only events are durable on this wire, so only they count. Of every 50 events of a vehicle 35 leave a
section, 13 move a door, and one pair each reports an obstacle or a fault and its end. Section and door are
the frequent events of a driving shuttle. Events whose effect is a decision about the fleet (visits, riders,
grants) are what `benchmarks.bookings` and `benchmarks.decisions` measure.
"""

import base64

import msgspec
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from benchmarks.ingest.city import Place
from contract.wire.codec import encode
from contract.wire.messages import (
    Blocked,
    Challenge,
    DoorsChanged,
    DriveMode,
    EventReport,
    FaultRaised,
    FaultReport,
    Hello,
    SectionReleased,
    Status,
    VehicleEvent,
    signed_hello,
)

BOOT = "boot-1"
CYCLE = 50
_EPOCH, _SEQUENCE, _STAMP = 111_111_111, 222_222_222, 333_333_333


def event_body(place: Place, sequence: int) -> VehicleEvent:
    """The vehicle's event with this number."""
    turn = sequence % CYCLE
    if turn in (10, 11):
        return Blocked(since_ns=turn, cleared=turn == 11, obstacle_m=4.0, pose_map=place.pose_map)
    if turn in (30, 31):
        return FaultRaised(FaultReport("tick_late", "warning", turn), cleared=turn == 31)
    if turn % 4 == 3:
        return DoorsChanged(turn % 8 == 3, "visit-7")
    return SectionReleased(f"{place.lane_id}/{turn}", turn)


class EventFrames:
    """The payloads of one vehicle's events: those of a cycle share everything but their numbers."""

    def __init__(self, place: Place) -> None:
        self._place = place
        self._pieces: list[tuple[bytes, bytes, bytes, bytes]] = []
        self._epoch = b""

    def begin(self, epoch: int) -> None:
        self._epoch = b"%d" % epoch
        self._pieces = [_pieces(event_body(self._place, turn)) for turn in range(CYCLE)]

    def payload(self, sequence: int) -> bytes:
        a, b, c, d = self._pieces[sequence % CYCLE]
        return b"%b%b%b%d%b%d%b" % (a, self._epoch, b, sequence, c, sequence, d)


def _pieces(body: VehicleEvent) -> tuple[bytes, bytes, bytes, bytes]:
    encoded = encode(EventReport(_EPOCH, BOOT, _SEQUENCE, _STAMP, body))
    before, _, rest = encoded.partition(b"%d" % _EPOCH)
    middle, _, rest = rest.partition(b"%d" % _SEQUENCE)
    third, _, after = rest.partition(b"%d" % _STAMP)
    return before, middle, third, after


def status_payload(
    place: Place, epoch: int, number: int, mode: DriveMode = "held", speed_mps: float | None = None
) -> bytes:
    """speed_mps: None for another one each time, so that screens have something to show"""
    return encode(
        Status(
            epoch=epoch,
            stamp_ns=number,
            pose_map=place.pose_map,
            speed_mps=4.0 + (number % 7) / 10.0 if speed_mps is None else speed_mps,
            accel_mps2=0.0,
            steer_rad=0.0,
            mode=mode,
            battery_ratio=0.8,
            doors_open=False,
            lane_id=place.lane_id,
            s_m=place.s_m,
            order_id="",
            revision=0,
            visit_id="",
        )
    )


def hello_payload(challenge: bytes, vehicle_id: str, key: Ed25519PrivateKey, map_version: str) -> bytes:
    """The signed answer to the server's challenge."""
    nonce = msgspec.json.decode(challenge, type=Challenge).nonce
    signature = key.sign(signed_hello(nonce, vehicle_id, BOOT, 1))
    return encode(
        Hello(
            protocol=1,
            vehicle_id=vehicle_id,
            boot_id=BOOT,
            nonce=nonce,
            signature=base64.b64encode(signature).decode(),
            software="benchmark",
            stack="none",
            map_version=map_version,
            vehicle_ns=1,
        )
    )
