"""A whole campus in virtual time: the server, the vehicles, the people and one conductor.

Clients use REST through in-memory ASGI, vehicles use in-memory pipes.
"""

import asyncio
import hashlib
from collections.abc import Coroutine
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, TypeVar

import httpx

from campusloop.clients.operator_client import OperatorClient
from campusloop.clients.passengers import JourneyListener, Passengers, RideDemand
from campusloop.virtual.cameras import VirtualCameras
from campusloop.virtual.conductor import Conductor
from campusloop.virtual.link import VirtualNetwork
from campusloop.virtual.vehicle import VirtualVehicle, VirtualVehicleSetup
from campusloop.virtual.virtual_server import VirtualPhones, VirtualServer
from contract.geometry import Pose2
from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.tracing import Spans
from contract.wire.messages import PresenceReport
from server.adapters import SeededIds
from server.api.runs.offload import InlineOffload
from server.app import Ports, create_app, services_of_app, standing_tasks
from server.bus.in_process import InProcessBus
from server.domain.rides.ticket_keys import TicketKeys
from server.domain.rules import FleetRules
from server.domain.service.timetable import ServiceHours
from server.settings import settings_from
from server.store.engine import open_engine
from server.store.roads.map_library import MapLibrary
from server.store.schema import upgrade_to_head
from server.store.transactions import InlineTransactions
from server.store.unit_of_work import Context
from server.usecases.fleet import campus
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity
from simulator.infrastructure import CameraParams
from simulator.riders import Rider
from simulator.sensors.scene_lidars import SceneOptions
from simulator.start_places import start_poses
from simulator.traffic.population import TrafficParams
from simulator.world import SimWorld, WorldOptions
from vehicle_agent.config import Profile
from vehicle_agent.link.keys import load_or_create_key, public_key_text

T = TypeVar("T")

START_NS = 1_000_000_000
OPERATOR = ("operator", "a password of the virtual campus")
ORIGIN = "http://campus.test"
# Known to everyone: the passengers of virtual time are simulated.
TICKET_KEYS = TicketKeys([b"the ticket key of virtual campus"])


class QuickHasher:
    """Password hashing for virtual time, where passwords are no secrets and argon2 would be slow."""

    def hash(self, password: str) -> str:
        return hashlib.sha256(password.encode()).hexdigest()

    def verify(self, password_hash: str, password: str) -> bool:
        return password_hash == self.hash(password)


@dataclass(frozen=True, slots=True)
class CampusOptions:
    """folder: where vehicles and server keep their files. begins: UTC at virtual time 0.

    cameras  parameters of the camera at each of the map's crossings; None for no cameras
    spans    of rides; None: they are not traced
    plant_seed  of the shuttles' dynamics; None: nominal ones
    scene    hills, kerbs, trees and parked vehicles, and lidars that see them; None: walls on a plane
    point_map  the folder of the map that the shuttles compare their scans with; None: GNSS/INS alone
    campus_sky  buildings hide satellites and reflect their signals; otherwise receivers have an open sky
    crossing_detector  cameras at crossings count people in simulated pictures; needs a scene and OpenCV
    """

    road_map: RoadMap
    folder: Path
    seed: int = 1
    vehicles: int = 2
    profile: Profile = field(default_factory=Profile)
    begins: datetime = datetime(2026, 9, 1, 0, 0, tzinfo=UTC)
    traffic: TrafficParams | None = field(default_factory=TrafficParams)
    lidar: bool = True
    cameras: CameraParams | None = field(default_factory=CameraParams)
    database_url: str = "sqlite://"
    spans: Spans | None = None
    plant_seed: int | None = None
    scene: SceneOptions | None = None
    point_map: Path | None = None
    campus_sky: bool = False
    crossing_detector: bool = False


class VirtualClock:
    """The server's clock: `begins` plus the conductor's time."""

    def __init__(self, conductor: Conductor, begins: datetime) -> None:
        self._conductor = conductor
        self._begins = begins

    def now(self) -> datetime:
        return self._begins + timedelta(microseconds=self._conductor.now_ns // 1000)


class _Fleet:
    """All vehicles and the world as one participant: each vehicle by id, then 20 ms of world."""

    def __init__(self, world: SimWorld, vehicles: dict[str, VirtualVehicle]) -> None:
        self._world = world
        self._vehicles = vehicles

    def step(self, now_ns: int) -> None:
        for vehicle in self._vehicles.values():
            vehicle.step(now_ns)
        self._world.step(now_ns)


class VirtualCampus:
    """Call `start`, then run the conductor. Use the campus through `client`, as from outside."""

    def __init__(self, options: CampusOptions) -> None:
        self.options = options
        self.conductor = Conductor(options.seed, START_NS)
        self.clock = VirtualClock(self.conductor, options.begins)
        # A server that starts again gives no name twice, as a real one does not.
        self._ids = SeededIds(options.seed)
        self.network = VirtualNetwork(self.conductor)
        self.roads = RoadNetwork(options.road_map)
        self._server = VirtualServer()
        self.client = httpx.AsyncClient(base_url=ORIGIN, transport=self._server)
        self.operator = OperatorClient(self.client)
        self._phones = VirtualPhones()
        self.world, self.vehicles = self._set_up_vehicles()
        self._lifespan: asyncio.Task[None] | None = None
        self._shutdown = asyncio.Event()

    # ------------------------------------------------------------ time

    def call(self, coroutine: Coroutine[Any, Any, T], timeout_s: float = 60.0) -> T:
        """Run until the coroutine is done. Raises TimeoutError after timeout_s."""
        task = self.conductor.loop.create_task(coroutine)
        if not self.conductor.run_until(task.done, timeout_s):
            raise TimeoutError(f"{coroutine!r} is not done after {timeout_s} virtual seconds")
        return task.result()

    def now(self) -> datetime:
        return self.clock.now()

    # ------------------------------------------------------------ server

    def start(self) -> None:
        """Start the server, enrol the vehicles, boot them, and release them when they are placed."""
        self.start_server()
        self.call(self.operator.sign_in(*OPERATOR))
        for vehicle in self.vehicles.values():
            self.call(self._enrol(vehicle))
            vehicle.boot(self.conductor.now_ns)
        self.conductor.add("fleet", _Fleet(self.world, self.vehicles))
        if self.options.cameras is not None:
            params = self.options.cameras
            cameras = VirtualCameras(
                self.options.road_map, params, self.world, self.conductor.rng, self._forward_presence,
                detector_seed=self.options.seed if self.options.crossing_detector else None,
            )  # fmt: skip
            self.conductor.add("cameras", cameras)
        self.conductor.loop.create_task(self._forward_taps())
        for vehicle_id in self.vehicles:
            self.call(self.operator.release(vehicle_id), timeout_s=60.0)

    def _forward_presence(self, report: PresenceReport) -> None:
        """As the infrastructure socket does. The report is lost while the server is down."""
        if self._server.app is not None:
            presence = services_of_app(self._server.app).presence
            self.conductor.loop.create_task(presence.seen(report))

    def start_server(self) -> None:
        """Start a server on the campus's database; the vehicles connect by themselves."""
        engine = open_engine(self.options.database_url)
        upgrade_to_head(engine)
        road_map = self.options.road_map
        rules = FleetRules(
            hours=ServiceHours(road_map.timezone, ()), speed_cap_mps=self.options.profile.limits.speed_mps_max
        )
        ids, bus = self._ids, InProcessBus()
        library = MapLibrary(rules)
        context = Context(road_map.campus_id, self.clock, ids, rules, QuickHasher(), library, TICKET_KEYS)
        transactions = InlineTransactions(engine, context, bus)

        def prepare(uow: UnitOfWork) -> None:
            campus.load_map(uow, encode_map(road_map), "start-up", activate=True)
            identity.set_password(uow, *OPERATOR)

        self.conductor.loop.run_now(transactions.run(prepare))
        ports = Ports(road_map.campus_id, self.clock, ids, transactions, bus, InlineOffload())
        ports = replace(ports, loops=standing_tasks(ports), spans=self.options.spans)
        settings = settings_from(
            {},
            var_dir=self.options.folder / "server",
            public_url=ORIGIN,
            login_tries_per_minute=1000,
            account_login_tries_per_minute=1000,
            commands_per_minute=1000,
            lookups_per_minute=1000,
            bookings_per_minute=1000,
        )
        app = create_app(settings, ports)
        self._server.app = app
        self._shutdown = asyncio.Event()
        shutdown = self._shutdown

        async def run_lifespan() -> None:
            async with app.router.lifespan_context(app):
                self.network.hub = services_of_app(app).hub
                await shutdown.wait()

        self._lifespan = self.conductor.loop.create_task(run_lifespan())
        self.conductor.loop.run_until_idle(self.conductor.now_ns)
        if self._lifespan.done():
            self._lifespan.result()

    def stop_server(self) -> None:
        """Stop the server. The vehicles continue with their granted sections; requests fail to connect."""
        self.network.hub = None
        self._server.app = None
        self._shutdown.set()
        assert self._lifespan is not None
        self.conductor.run_until(self._lifespan.done, 30.0)
        self._lifespan.result()

    def stop(self) -> None:
        """Close every run log, then stop the server."""
        self.conductor.remove("fleet")
        for vehicle in self.vehicles.values():
            vehicle.link.drop()
            vehicle.shut_down()
        self.stop_server()

    # ------------------------------------------------------------ people

    def passengers(self, on_change: JourneyListener) -> Passengers:
        """Simulated passengers of this campus."""
        self._passengers = Passengers(self.client, self, self.clock.now, on_change)
        return self._passengers

    def add(self, ticket: dict[str, Any], demand: RideDemand) -> None:
        self.world.riders.add(
            Rider(
                ticket["ride_id"],
                ticket["boarding_code"],
                demand.party,
                demand.how,
                self.stop_pose(demand.from_stop),
                self.stop_pose(demand.to_stop),
                self.conductor.now_ns,
            )
        )

    def assigned(self, ride_id: str, vehicle_id: str) -> None:
        self._phones.vehicles[ride_id] = vehicle_id

    def stop_pose(self, stop_id: str) -> Pose2:
        (stop,) = [stop for stop in self.options.road_map.stops if stop.stop_id == stop_id]
        return Pose2(*self.roads.pose(stop.lane_id, stop.s_m))

    async def _forward_taps(self) -> None:
        while True:
            await asyncio.sleep(0.2)
            taps, self._phones.taps = self._phones.taps, []
            for ride_id, kind in taps:
                await self._passengers.tap(ride_id, kind)

    # ------------------------------------------------------------ vehicles

    def _set_up_vehicles(self) -> tuple[SimWorld, dict[str, VirtualVehicle]]:
        options = self.options
        vehicle_ids = tuple(f"shuttle-{number}" for number in range(1, options.vehicles + 1))
        world = SimWorld(
            options.road_map,
            dict.fromkeys(vehicle_ids, options.profile),
            start_poses(options.road_map, vehicle_ids),
            options.seed,
            self._phones,
            WorldOptions(
                traffic=options.traffic,
                lidar=options.lidar,
                plant_seed=options.plant_seed,
                scene=options.scene,
                campus_sky=options.campus_sky,
            ),
        )
        begins_ns = int(options.begins.timestamp()) * 1_000_000_000
        vehicles = {
            vehicle_id: VirtualVehicle(
                VirtualVehicleSetup(
                    vehicle_id,
                    options.profile,
                    options.road_map,
                    options.folder / vehicle_id,
                    begins_ns,
                    options.spans,
                    options.point_map,
                ),
                world,
                self.network.dialler(vehicle_id),
            )
            for vehicle_id in vehicle_ids
        }
        return world, vehicles

    async def _enrol(self, vehicle: VirtualVehicle) -> None:
        setup = vehicle.setup
        key = load_or_create_key(setup.folder / "key.pem")
        await self.operator.enrol(setup.vehicle_id, setup.profile.body, public_key_text(key))
