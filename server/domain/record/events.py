"""Events as the server stores them, identified by (vehicle, boot, sequence)."""

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import NamedTuple

from contract.wire.messages import VehicleEvent

# A command is repeated until it is answered; one that waits longer found no vehicle.
ANSWERED_WITHIN = timedelta(hours=1)


class RecordedEvent(NamedTuple):
    """stamp_ns is the vehicle's clock, received_ns the server's (UTC); both are kept.

    A named tuple, since thousands of them are made in a second.
    """

    vehicle_id: str
    boot_id: str
    sequence: int
    stamp_ns: int
    received_ns: int
    body: VehicleEvent


@dataclass(frozen=True, slots=True)
class ServerEvent:
    """An action of the server or a person: `noun.verb`, subject, author and details."""

    campus_id: str
    happened_at: datetime
    name: str
    subject: str
    by: str = ""
    detail: str = ""
