"""What a screen shows of the campus at one moment: the same shape live and replayed.

These structs travel to browsers, so times are milliseconds since the Unix epoch (a JavaScript number holds
them exactly). Positions are in the map frame, angles as in REP-103. `SceneBoard` holds the present moment.
"""

from collections import deque
from collections.abc import Hashable, Iterable
from typing import TypeVar

import msgspec

from contract.roads.model import Point
from contract.wire.messages import CommandKind, DriveMode, Status, VisitKind, VisitState
from server.domain.fleet.vehicles import CommandState
from server.domain.planning.plans import RestReason

T = TypeVar("T")
Items = dict[str, tuple[int, T]]

REMOVALS_KEPT = 1_000


class VehicleFacts(msgspec.Struct, frozen=True):
    """A vehicle's stored facts; names and meanings are those of `domain.fleet.vehicles.Vehicle`."""

    name: str
    seats: int
    wheelchair_places: int = 0
    connected: bool = False
    held: bool = False
    in_service: bool = True
    charging: bool = False
    mode: DriveMode = "held"


class VisitScene(msgspec.Struct, frozen=True):
    """A visit of a vehicle's plan that is not done.

    boarding, alighting  how many rides begin and end there
    eta_ms  0 while the plan has none; why: a rest is made to charge or where riders are expected
    """

    visit_id: str
    kind: VisitKind
    state: VisitState
    stop_id: str
    boarding: int
    alighting: int
    eta_ms: int
    why: RestReason


class VehicleTask(msgspec.Struct, frozen=True):
    """A vehicle's plan.

    visits         in driving order, for operators
    order_waits    the newest plan waits until its route is safe
    hold_ends_ms   when the server resumes it, 0 when an operator does
    unavailable_since_ms  since when it has been held, out of reach or quarantined; 0 while it is neither
    charged_at_ms  when it will have charged, 0 when it does not charge
    next_stop      stop_id of the visit it drives to or stands at, "" when it only goes to rest
    people_aboard  people of the rides aboard
    at_charger     it rests where it is charged
    route          where it will drive, from where it was when its task last changed, simplified to 0.5 m
    """

    next_stop: str = ""
    people_aboard: int = 0
    at_charger: bool = False
    route: tuple[Point, ...] = ()
    visits: tuple[VisitScene, ...] = ()
    order_waits: bool = False
    hold_ends_ms: int = 0
    charged_at_ms: int = 0
    unavailable_since_ms: int = 0


class CommandScene(msgspec.Struct, frozen=True):
    """A command to a vehicle and how it ended; `detail` is the vehicle's reason for a refusal."""

    command_id: str
    kind: CommandKind
    state: CommandState
    detail: str
    by: str
    made_ms: int


class VehicleScene(msgspec.Struct, frozen=True):
    """One vehicle on the screen.

    facts    from the store
    task     from its plan and order
    status   its newest status as it came over the wire, rounded; None before the first. Its `driving` is for
             operators, and reaches screens by the bus only
    heard_ms when the server received that status; 0 for never
    command  the newest command to it, None when there never was one
    """

    vehicle_id: str
    facts: VehicleFacts
    task: VehicleTask = VehicleTask()
    status: Status | None = None
    heard_ms: int = 0
    command: CommandScene | None = None


class RideScene(msgspec.Struct, frozen=True):
    """One ride that has not ended yet, or has ended a moment ago.

    pickup_earliest_ms, pickup_latest_ms  0 while no time can be promised
    arrival_earliest_ms, arrival_latest_ms  0 while it has no shuttle, gets on, or no time can be told
    seats_left  free seats of its shuttle beside the party; None while not known
    """

    ride_id: str
    ride_code: str
    state: str
    from_stop: str
    to_stop: str
    party: int
    vehicle_id: str = ""
    pickup_from_ms: int = 0
    pickup_to_ms: int = 0
    arrive_by_ms: int = 0
    pickup_eta_ms: int = 0
    arrival_eta_ms: int = 0
    reason: str = ""
    pickup_earliest_ms: int = 0
    pickup_latest_ms: int = 0
    seats_left: int | None = None
    arrival_earliest_ms: int = 0
    arrival_latest_ms: int = 0


class AreaScene(msgspec.Struct, frozen=True):
    """An observation area that a camera watches: how many people it saw last, and when."""

    area_id: str
    count: int
    heard_ms: int


class IncidentsScene(msgspec.Struct, frozen=True):
    """serial grows whenever an incident changes: fetch the list again."""

    open: int = 0
    unacknowledged: int = 0
    help_calls: int = 0
    serial: int = 0


class Scene(msgspec.Struct, frozen=True):
    """Everything that one viewer may see at `at_ms`."""

    at_ms: int
    campus_id: str
    map_version: str
    vehicles: tuple[VehicleScene, ...] = ()
    rides: tuple[RideScene, ...] = ()
    incidents: IncidentsScene = IncidentsScene()
    areas: tuple[AreaScene, ...] = ()


class Snapshot(msgspec.Struct, frozen=True, tag="snapshot", tag_field="type"):
    """First message on /ws/live, and again whenever the campus changes its map."""

    scene: Scene


class Delta(msgspec.Struct, frozen=True, tag="delta", tag_field="type"):
    """What changed since the message before: whole vehicles and rides, and the ids of those gone.

    incidents is null when it did not change.
    """

    at_ms: int
    vehicles: tuple[VehicleScene, ...] = ()
    vehicles_gone: tuple[str, ...] = ()
    rides: tuple[RideScene, ...] = ()
    rides_gone: tuple[str, ...] = ()
    incidents: IncidentsScene | None = None
    areas: tuple[AreaScene, ...] = ()


class SceneBoard:
    """The campus now. Every change gets a number, by which viewers know what is new to them.

    The items stand in the order of their changes, so that what is new is found without looking at the rest.
    """

    def __init__(self, campus_id: str) -> None:
        self.campus_id = campus_id
        self.map_version = ""
        self.incidents = IncidentsScene()
        self.vehicles: Items[VehicleScene] = {}
        self.rides: Items[RideScene] = {}
        self.areas: Items[AreaScene] = {}
        # The removals that a viewer may not know of yet, and the number of the last one that is forgotten.
        self._removals: deque[tuple[int, str, str]] = deque()
        self._forgotten = 0
        self.change = 0
        # What the last viewer of everything was told, and what for.
        self.last_delta: tuple[Hashable, Delta] | None = None

    def vehicle(self, vehicle_id: str) -> VehicleScene | None:
        held = self.vehicles.get(vehicle_id)
        return None if held is None else held[1]

    def put_vehicle(self, vehicle: VehicleScene) -> None:
        if self.vehicle(vehicle.vehicle_id) != vehicle:
            self._put(self.vehicles, vehicle.vehicle_id, vehicle)

    def put_ride(self, ride: RideScene) -> None:
        held = self.rides.get(ride.ride_id)
        if held is None or held[1] != ride:
            self._put(self.rides, ride.ride_id, ride)

    def put_area(self, area: AreaScene) -> None:
        self._put(self.areas, area.area_id, area)

    def remove_vehicle(self, vehicle_id: str) -> None:
        if self.vehicles.pop(vehicle_id, None) is not None:
            self._note_removal("vehicle", vehicle_id)

    def remove_ride(self, ride_id: str) -> None:
        if self.rides.pop(ride_id, None) is not None:
            self._note_removal("ride", ride_id)

    def knows_all_since(self, change: int) -> bool:
        """False if something that was removed after that change is forgotten."""
        return change >= self._forgotten

    def vehicles_gone_since(self, change: int) -> tuple[str, ...]:
        return tuple(item for item in self._gone_since("vehicle", change) if item not in self.vehicles)

    def rides_gone_since(self, change: int) -> tuple[str, ...]:
        return tuple(item for item in self._gone_since("ride", change) if item not in self.rides)

    def _put(self, items: "Items[T]", key: str, item: T) -> None:
        items.pop(key, None)
        self.change += 1
        items[key] = (self.change, item)

    def _note_removal(self, kind: str, key: str) -> None:
        self.change += 1
        self._removals.append((self.change, kind, key))
        if len(self._removals) > REMOVALS_KEPT:
            self._forgotten, _, _ = self._removals.popleft()

    def _gone_since(self, kind: str, change: int) -> Iterable[str]:
        gone: dict[str, None] = {}
        for number, of_kind, key in reversed(self._removals):
            if number <= change:
                break
            if of_kind == kind:
                gone[key] = None
        return gone


def changed_since(items: "Items[T]", change: int) -> tuple[T, ...]:
    """The items that have changed after that change, the oldest change first."""
    found: list[T] = []
    for number, item in reversed(items.values()):
        if number <= change:
            break
        found.append(item)
    return tuple(reversed(found))
