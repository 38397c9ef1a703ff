"""Orders and sections, from the server; how far the vehicle has come with them, in its answers."""

from typing import Annotated, Literal

import msgspec

from contract.wire.base import Message
from contract.wire.bounds import (
    ArcLength,
    Count,
    Duration,
    Id,
    LongText,
    PlaceId,
    Places,
    RideCode,
    ShortText,
    StampNs,
)

# Of one order: far more than a shuttle serves or a campus has.
VISITS_MAX = 1_000
RIDERS_MAX = 200
LANES_MAX = 10_000

VisitState = Literal["pending", "under_way", "done", "skipped"]
VisitKind = Literal["stop", "rest", "temporary"]


class VisitProgress(msgspec.Struct, frozen=True):
    visit_id: Id
    state: VisitState


class OrderProgress(msgspec.Struct, frozen=True):
    """The order that the vehicle follows and how far it has come: its own record of what has happened."""

    order_id: Id
    revision: Count
    visits: Annotated[tuple[VisitProgress, ...], msgspec.Meta(max_length=VISITS_MAX)]
    sections: Annotated[tuple[PlaceId, ...], msgspec.Meta(max_length=LANES_MAX)] = ()


class RiderTask(msgspec.Struct, frozen=True):
    """One ride's party at a visit. The code is what a rider types on the onboard screen."""

    ride_id: Id
    party: Places
    code: RideCode = ""


class Visit(msgspec.Struct, frozen=True):
    """Go to a place and stand there.

    route       lanes from the end of the visit before (or from where the order was made) to `lane_id`,
                both ends included; empty when the vehicle already stands there
    s_m         where the rear axle shall stand on `lane_id`
    dwell_s     how long doors stay open at least, once standing
    not_before_ns  server time up to which the vehicle waits for those who board here, 0 for none
    timed       a timetable departure: the vehicle waits until not_before_ns even with no rider to board
    """

    visit_id: Id
    kind: VisitKind
    stop_id: PlaceId
    lane_id: PlaceId
    s_m: ArcLength
    route: Annotated[tuple[PlaceId, ...], msgspec.Meta(max_length=LANES_MAX)]
    board: Annotated[tuple[RiderTask, ...], msgspec.Meta(max_length=RIDERS_MAX)] = ()
    alight: Annotated[tuple[RiderTask, ...], msgspec.Meta(max_length=RIDERS_MAX)] = ()
    dwell_s: Duration = 15.0
    not_before_ns: StampNs = 0
    timed: bool = False
    name: ShortText = ""
    name_en: ShortText = ""


class SectionGrant(msgspec.Struct, frozen=True, array_like=True):
    """A reservation: this vehicle alone may enter the section. A higher fence replaces a lower one."""

    section_id: PlaceId
    fence: Count


class Order(Message, frozen=True, tag="order"):
    """What shall happen. A higher revision replaces a lower one; repeats are harmless.

    visits      in driving order, done ones left out; the last one is a rest visit
    sections    every grant the vehicle holds, in route order
    expires_ns  server time after which the vehicle must not accept this order any more
    """

    epoch: Count
    order_id: Id
    revision: Count
    map_version: ShortText
    visits: Annotated[tuple[Visit, ...], msgspec.Meta(max_length=VISITS_MAX)]
    sections: Annotated[tuple[SectionGrant, ...], msgspec.Meta(max_length=LANES_MAX)]
    expires_ns: StampNs


class Grants(Message, frozen=True, tag="grants"):
    """All sections granted for the order's remaining route, in route order; replaces earlier lists."""

    epoch: Count
    order_id: Id
    sections: Annotated[tuple[SectionGrant, ...], msgspec.Meta(max_length=LANES_MAX)]


class OrderAccepted(Message, frozen=True, tag="order_accepted"):
    """The vehicle has the order on disk and follows it."""

    epoch: Count
    order_id: Id
    revision: Count


class OrderRejected(Message, frozen=True, tag="order_rejected"):
    """The vehicle keeps what it had. `visits` is its own state, so that the server can mend its plan."""

    epoch: Count
    order_id: Id
    revision: Count
    code: Literal["visit_under_way", "expired", "map_version", "stale_revision", "unreachable", "malformed"]
    detail: LongText
    visits: Annotated[tuple[VisitProgress, ...], msgspec.Meta(max_length=VISITS_MAX)] = ()
