"""Vehicles as the server stores them, and the commands to them."""

from dataclasses import dataclass, replace
from datetime import datetime
from typing import Literal

from contract.geometry import Pose2
from contract.localization_manifest import LocalizationMapKind
from contract.wire.bounds import SEATS_MAX
from contract.wire.messages import CommandKind, DriveMode, Status
from server.domain.fleet.shifts import Shifts

CommandState = Literal["pending", "done", "failed"]

# A vehicle that is slower stands: the speed of a standing one is measured with noise.
STANDS_MPS = 0.1


@dataclass(frozen=True, slots=True)
class Vehicle:
    """Facts that change seldom; where it is now is in `Whereabouts`.

    epoch       the number of its newest session: older ones are fenced
    mode        the vehicle's newest report
    held        it stands until an operator resumes it
    in_service  it may get new rides; a recalled vehicle finishes those aboard and rests
    unavailable_since  since when it has not been `is_available`, None while it is
    hold_ends   an operator's hold is over then, and the server resumes it; None: it stands until resumed
    charging    it went to charge and has not charged to the full yet
    placed      it holds the ground under its body, so that it can be given a route
    shifts      when it is on duty, None for always
    quarantined_at  when it last broke the protocol: until it has kept to it for a while it gets no rides
    map_failure  why it cannot take the map in force (`contract.wire.maps`), "" if it can or has not said:
                 its orders would not fit the roads
    localizes_by  the kind of map that it compares scans with, "" for none
    localization_map  the version that it compares them with, "" for none
    localization_change  of the localization map in force: "" nothing yet, "stored" it has the map and waits
                  until it stands, else why it keeps its own (`contract.wire.localization_maps`)
    """

    campus_id: str
    vehicle_id: str
    name: str
    seats: int
    wheelchair_places: int
    enrolled_at: datetime
    epoch: int = 0
    boot_id: str = ""
    connected: bool = False
    software: str = ""
    stack: str = ""
    map_version: str = ""
    mode: DriveMode = "held"
    held: bool = True
    in_service: bool = True
    placed: bool = False
    retired: bool = False
    unavailable_since: datetime | None = None
    hold_ends: datetime | None = None
    charging: bool = False
    shifts: Shifts | None = None
    quarantined_at: datetime | None = None
    map_failure: str = ""
    localizes_by: LocalizationMapKind | Literal[""] = ""
    localization_map: str = ""
    localization_change: str = ""

    @property
    def is_available(self) -> bool:
        """It drives by itself and by the campus's map, is within reach, and its word can be relied on."""
        is_trusted = self.quarantined_at is None and not self.map_failure
        return self.connected and not self.held and is_trusted

    @property
    def accepts_rides(self) -> bool:
        """New rides may be promised on it."""
        return self.in_service and self.placed and self.is_available and not self.retired


def within_bounds(vehicle: Vehicle) -> Vehicle:
    """A stored vehicle as it may be used: one with values that no vehicle can have is quarantined.

    What a former version let in must not reach the dispatcher's arithmetic.
    """
    seats = min(max(vehicle.seats, 1), SEATS_MAX)
    places = min(max(vehicle.wheelchair_places, 0), seats)
    if (seats, places) == (vehicle.seats, vehicle.wheelchair_places):
        return vehicle
    since = vehicle.quarantined_at or vehicle.enrolled_at
    return replace(vehicle, seats=seats, wheelchair_places=places, quarantined_at=since)


@dataclass(frozen=True, slots=True)
class Whereabouts:
    """A vehicle's newest status and when it was heard last (any frame counts).

    unreadable  why the stored status cannot be used; status is None then
    """

    vehicle_id: str
    heard_at: datetime
    status: Status | None = None
    unreadable: str = ""


@dataclass(frozen=True, slots=True)
class StatusReport:
    """A status on its way into the store."""

    vehicle_id: str
    boot_id: str
    received_at: datetime
    status: Status


@dataclass(frozen=True, slots=True)
class VehicleCommand:
    """A command of an operator or developer to one vehicle, repeated until the vehicle answers it.

    detail  the vehicle's reason when it refused, or what came of it
    pose    of `set_position`: where an operator says that the vehicle stands, map frame
    announcement_id  of the announcement to riders that it says, "" for none
    """

    campus_id: str
    command_id: str
    vehicle_id: str
    kind: CommandKind
    text: str
    by: str
    made_at: datetime
    state: CommandState = "pending"
    detail: str = ""
    announcement_id: str = ""
    pose: Pose2 | None = None


@dataclass(frozen=True, slots=True)
class VehicleSession:
    """What the link needs to greet a vehicle: its epoch, and which event of each boot comes next."""

    vehicle_id: str
    epoch: int
    acknowledged: tuple[tuple[str, int], ...]
