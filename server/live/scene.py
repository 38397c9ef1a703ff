"""What a screen shows of the campus at one moment: the same shape live and replayed.

These structs travel to browsers, so times are milliseconds since the Unix epoch (a JavaScript number holds
them exactly). Positions are in the map frame, angles as in REP-103. `SceneBoard` holds the present moment.
"""

import itertools

import msgspec

from contract.roads.model import Point
from contract.wire.messages import DrivingView


class VehicleScene(msgspec.Struct, frozen=True):
    """One shuttle on the screen.

    heard_ms    when the server last heard it; 0 for never
    located     False while nobody knows where it is: the pose then means nothing
    route       where it will drive, from where it was when its task last changed, simplified to 0.5 m
    charging    it rests where it is charged
    driving     what it sees and plans, for operators; null before its first report
    next_stop   stop_id of the visit it drives to or stands at, "" when it only goes to rest
    """

    vehicle_id: str
    name: str
    seats: int
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    speed_mps: float = 0.0
    located: bool = False
    mode: str = "held"
    connected: bool = False
    held: bool = False
    in_service: bool = True
    heard_ms: int = 0
    battery_ratio: float = 0.0
    charging: bool = False
    doors_open: bool = False
    obstacle_m: float | None = None
    waiting_for: str = ""
    screen: str = ""
    spoken: str = ""
    order_id: str = ""
    visit_id: str = ""
    next_stop: str = ""
    aboard: tuple[str, ...] = ()
    people_aboard: int = 0
    faults: tuple[str, ...] = ()
    route: tuple[Point, ...] = ()
    driving: DrivingView | None = None


class RideScene(msgspec.Struct, frozen=True):
    """One ride that has not ended yet, or has ended a moment ago."""

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
    """The campus now. Every change gets a number, by which viewers know what is new to them."""

    def __init__(self, campus_id: str) -> None:
        self.campus_id = campus_id
        self.map_version = ""
        self.incidents = IncidentsScene()
        self.vehicles: dict[str, tuple[int, VehicleScene]] = {}
        self.rides: dict[str, tuple[int, RideScene]] = {}
        self.areas: dict[str, tuple[int, AreaScene]] = {}
        self._change = itertools.count(1)

    def vehicle(self, vehicle_id: str) -> VehicleScene | None:
        held = self.vehicles.get(vehicle_id)
        return None if held is None else held[1]

    def put_vehicle(self, vehicle: VehicleScene) -> None:
        if self.vehicle(vehicle.vehicle_id) != vehicle:
            self.vehicles[vehicle.vehicle_id] = (next(self._change), vehicle)

    def put_ride(self, ride: RideScene) -> None:
        held = self.rides.get(ride.ride_id)
        if held is None or held[1] != ride:
            self.rides[ride.ride_id] = (next(self._change), ride)

    def put_area(self, area: AreaScene) -> None:
        self.areas[area.area_id] = (next(self._change), area)

    def remove_vehicle(self, vehicle_id: str) -> None:
        self.vehicles.pop(vehicle_id, None)

    def remove_ride(self, ride_id: str) -> None:
        self.rides.pop(ride_id, None)
