"""Orders and sections, from the server; how far the vehicle has come with them, in its answers."""

from typing import Literal

import msgspec

from contract.wire.base import Message

VisitState = Literal["pending", "under_way", "done", "skipped"]
VisitKind = Literal["stop", "rest", "temporary"]


class VisitProgress(msgspec.Struct, frozen=True):
    visit_id: str
    state: VisitState


class OrderProgress(msgspec.Struct, frozen=True):
    """The order that the vehicle follows and how far it has come: its own record of what has happened."""

    order_id: str
    revision: int
    visits: tuple[VisitProgress, ...]
    sections: tuple[str, ...] = ()


class RiderTask(msgspec.Struct, frozen=True):
    """One ride's party at a visit. The code is what a rider types on the onboard screen."""

    ride_id: str
    party: int
    code: str = ""


class Visit(msgspec.Struct, frozen=True):
    """Go to a place and stand there.

    route       lanes from the end of the visit before (or from where the order was made) to `lane_id`,
                both ends included; empty when the vehicle already stands there
    s_m         where the rear axle shall stand on `lane_id`
    dwell_s     how long doors stay open at least, once standing
    not_before_ns  server time up to which the vehicle waits for those who board here, 0 for none
    timed       a timetable departure: the vehicle waits until not_before_ns even with no rider to board
    """

    visit_id: str
    kind: VisitKind
    stop_id: str
    lane_id: str
    s_m: float
    route: tuple[str, ...]
    board: tuple[RiderTask, ...] = ()
    alight: tuple[RiderTask, ...] = ()
    dwell_s: float = 15.0
    not_before_ns: int = 0
    timed: bool = False
    name: str = ""
    name_en: str = ""


class SectionGrant(msgspec.Struct, frozen=True, array_like=True):
    """A reservation: this vehicle alone may enter the section. A higher fence replaces a lower one."""

    section_id: str
    fence: int


class Order(Message, frozen=True, tag="order"):
    """What shall happen. A higher revision replaces a lower one; repeats are harmless.

    visits      in driving order, done ones left out; the last one is a rest visit
    sections    every grant the vehicle holds, in route order
    expires_ns  server time after which the vehicle must not accept this order any more
    """

    epoch: int
    order_id: str
    revision: int
    map_version: str
    visits: tuple[Visit, ...]
    sections: tuple[SectionGrant, ...]
    expires_ns: int


class Grants(Message, frozen=True, tag="grants"):
    """All sections granted for the order's remaining route, in route order; replaces earlier lists."""

    epoch: int
    order_id: str
    sections: tuple[SectionGrant, ...]


class OrderAccepted(Message, frozen=True, tag="order_accepted"):
    """The vehicle has the order on disk and follows it."""

    epoch: int
    order_id: str
    revision: int


class OrderRejected(Message, frozen=True, tag="order_rejected"):
    """The vehicle keeps what it had. `visits` is its own state, so that the server can mend its plan."""

    epoch: int
    order_id: str
    revision: int
    code: Literal["visit_under_way", "expired", "map_version", "stale_revision", "unreachable", "malformed"]
    detail: str
    visits: tuple[VisitProgress, ...] = ()
