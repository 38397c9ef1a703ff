"""Infrastructure cameras: their reports, and what the vehicles get of them."""

from typing import Annotated

import msgspec

from contract.wire.base import Message
from contract.wire.bounds import Count, Id, LongText, PeopleCount, PlaceId, StampNs


class PresenceReport(Message, frozen=True, tag="presence_report"):
    """Camera, once to ten times a second: how many people are in an observation area; latest wins.

    age_s  since the picture was taken, by the camera's own clock: it needs no other one
    """

    area_id: Annotated[str, msgspec.Meta(min_length=1, max_length=80)]
    count: Annotated[int, msgspec.Meta(ge=0, le=1000)]
    age_s: Annotated[float, msgspec.Meta(ge=0.0, le=10.0)] = 0.0


class PresenceRefused(Message, frozen=True, tag="presence_refused"):
    """Server: this word was not taken, and why. The connection stays open unless the token is at fault."""

    code: Id
    detail: LongText


class Presence(Message, frozen=True, tag="presence"):
    """How many people an infrastructure camera sees in an area. Neither acknowledged nor repeated.

    server_ns: when the camera took its picture, in the server's clock
    """

    epoch: Count
    area_id: PlaceId
    server_ns: StampNs
    count: PeopleCount
