"""What /ws/developer takes and gives besides JSON-RPC's own frame: params, results, notifications."""

from datetime import datetime
from typing import Annotated, Literal

import msgspec

from contract.wire.events import VehicleEvent
from server.api.commands import KEY_CHARACTERS_MAX, KEY_CHARACTERS_MIN, KEY_PATTERN
from server.domain.fleet.vehicles import CommandState
from server.domain.rides.rides import RideState
from server.live.scene import RideScene, VehicleScene

Topic = Literal["vehicles", "rides", "events"]
VehicleName = Annotated[str, msgspec.Meta(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9._@:-]+$")]
StopName = Annotated[str, msgspec.Meta(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f]+$")]
Key = Annotated[
    str,
    msgspec.Meta(min_length=KEY_CHARACTERS_MIN, max_length=KEY_CHARACTERS_MAX, pattern=KEY_PATTERN),
]


class NoParams(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Nothing."""


class ListRides(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Newest request first. states: all when left out. cursor: `next_cursor` of the page before."""

    states: list[RideState] | None = None
    limit: Annotated[int, msgspec.Meta(ge=1, le=500)] = 100
    cursor: Annotated[str, msgspec.Meta(min_length=1, max_length=400)] | None = None


class VehicleCommandParams(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """idempotency_key: a repeat with it within a day gets the first answer."""

    vehicle_id: VehicleName
    idempotency_key: Key | None = None


class SendToStop(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """dry_run: only answer what it would do.

    idempotency_key: a repeat with it within a day gets the first answer.
    """

    vehicle_id: VehicleName
    stop_id: StopName
    dry_run: bool = False
    idempotency_key: Key | None = None


class Topics(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    topics: Annotated[list[Topic], msgspec.Meta(min_length=1, max_length=3)]


class RidesPage(msgspec.Struct, frozen=True):
    """next_cursor: for the next page, with the same states; null on the last one."""

    rides: tuple[RideScene, ...]
    next_cursor: str | None = None


class SentVisit(msgspec.Struct, frozen=True):
    """The visit that the vehicle will make; eta is null while the plan has none."""

    visit_id: str
    plan_version: int
    eta: datetime | None


class CommandReceipt(msgspec.Struct, frozen=True):
    """The command is on its way; the vehicle's answer is in the topic `vehicles`."""

    command_id: str
    state: CommandState


class VehiclesChanged(msgspec.Struct, frozen=True):
    """Whole vehicles that changed, and the ids of those gone. snapshot: these are all there are."""

    at_ms: int
    snapshot: bool
    vehicles: tuple[VehicleScene, ...]
    gone: tuple[str, ...] = ()


class RidesChanged(msgspec.Struct, frozen=True):
    """Whole rides that changed, and the ids of those gone. snapshot: these are all there are."""

    at_ms: int
    snapshot: bool
    rides: tuple[RideScene, ...]
    gone: tuple[str, ...] = ()


class EventHappened(msgspec.Struct, frozen=True):
    """An event as the vehicle reported it. Those that happen while no socket is open are not repeated."""

    vehicle_id: str
    boot_id: str
    sequence: int
    body: VehicleEvent


class ConnectionRefused(msgspec.Struct, frozen=True):
    """Last message before the server closes: why, and what to do."""

    code: str
    detail: str


# By the notification's method.
NOTIFICATIONS: dict[str, type[msgspec.Struct]] = {
    "vehicles": VehiclesChanged,
    "rides": RidesChanged,
    "events": EventHappened,
    "refused": ConnectionRefused,
}
