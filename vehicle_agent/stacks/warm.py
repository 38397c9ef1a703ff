"""Calls every onboard kernel once, so that numba has compiled it before the first tick."""

import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.roads.load import decode_map, encode_map
from contract.roads.model import Lane, ObservationArea, Origin, RestingPlace, RoadMap, Section
from contract.roads.projection import unproject
from contract.wire.messages import Command, Order, SectionGrant, Visit
from vehicle_agent.config import ByWire, LidarMount, Profile
from vehicle_agent.localization.odometry_ekf import GYRO_BIAS, SIZE, correct_entry
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.onboard.tick import tick
from vehicle_agent.perception.height_map import percept_from_scan
from vehicle_agent.signals import (
    CYCLIST,
    PEDESTRIAN,
    VEHICLE,
    Ego,
    FleetVehicle,
    GnssFix,
    ImuSample,
    Inputs,
    LinkState,
    MissionMessage,
    PedestrianPresence,
    Percept,
    PlanAnswer,
    SeatButton,
    TrackPercept,
    Tracks,
    VehicleMotion,
    World,
)
from vehicle_agent.signals.rates import TICK_NS
from vehicle_agent.stacks.choice import build_car, build_planner
from vehicle_agent.stacks.rooms import guard, height_map

_TICKS = 60


def warm_kernels() -> None:
    """Drives a straight road for a moment with each stack: each kernel is called with a tick's types."""
    warm_gem()
    warm_nus()
    warm_snow_lion()


def warm_gem() -> None:
    warm_tick(Profile())


def warm_nus() -> None:
    warm_tick(Profile(stack="nus", by_wire=ByWire(kind="servo")))


def warm_snow_lion() -> None:
    """With a lidar, and with a tracker alone."""
    for lidar in (LidarMount(), LidarMount(rate_hz=0.0)):
        warm_tick(Profile(stack="snow_lion", lidar=lidar))


def warm_tick(profile: Profile) -> None:
    """Warms the profile's stack in the tick's process, before the first tick.

    A stack's first motion loads its kernels and solvers. This took 56 to 69 ms, and the gate brakes for a
    tick that is silent for so long.
    """
    _drive(profile, _with_observation_area(straight_road()))
    warm_standing()
    warm_guard(profile)
    if profile.stack == "snow_lion":
        warm_rolling(profile)


def warm_standing() -> None:
    """Warms what localization does once the vehicle has stood for a while: the drive above never does."""
    correct_entry(np.zeros(SIZE), np.eye(SIZE), GYRO_BIAS, 0.01, 1e-4, 9.0)


def warm_guard(profile: Profile) -> None:
    """Warms the guard's kernels, which a vehicle first needs when it drives among road users."""
    now_ns = TICK_NS
    avoidance = guard(profile).avoidance
    ego = Ego(now_ns, Pose2(0.0, 0.0, 0.0), 2.0, 0.0, 0.0, 0.0, 0.02, now_ns, True)
    motion = VehicleMotion(now_ns, 2.0, 0.0, 0.0, 0.0, True, False, True, 1.0)
    percept = _tracks(now_ns)
    tracks = Tracks(
        now_ns, percept.ids, percept.kinds, percept.poses_base, percept.velocities_base_mps, percept.sizes_m
    )
    fleet_vehicles = (FleetVehicle(now_ns, "fleet-vehicle", Pose2(15.0, 0.0, 0.0), 0.0),)
    world = World(now_ns, now_ns, np.array([[8.0, 0.0]]), fleet_vehicles, (), False, tracks)
    movers, obstacles = avoidance.road_users(world, ego)
    avoidance.brake_ratio(obstacles, ego, motion, 0.1, 2.0, False)
    avoidance.may_set_off(movers, obstacles, 0.1)
    avoidance.alongside_mps(movers)


def warm_rolling(profile: Profile) -> None:
    """Warms what Snow Lion's control learns from a vehicle that rolls: in the drive above it stands."""
    # Its solver is not imported where another stack drives.
    from vehicle_agent.stacks.snow_lion_control import control

    observer = control(profile).observer
    state, commands = observer.initial(), np.zeros((1, 3))
    for number in (1, 2):
        now_ns = number * TICK_NS
        ego = Ego(now_ns, Pose2(0.0, 0.0, 0.0), 2.0, 0.0, 0.0, 0.0, 0.02, now_ns, True)
        motion = VehicleMotion(now_ns, 2.0, 0.0, 0.0, 0.0, True, False, True, 1.0)
        state = observer.step(state, ego, motion, commands, False)


def _drive(profile: Profile, road_map: RoadMap) -> None:
    car, planner = build_car(profile, road_map), build_planner(profile, road_map)
    plans: tuple[PlanAnswer, ...] = ()
    state = initial_state(car)
    params = height_map(profile)
    points = np.array([[9.0, 0.0, z] for z in (0.0, 0.8, 1.6)] * 3, dtype=np.float32)
    messages: tuple[MissionMessage, ...] = (_order(road_map), Command(1, "go", "resume"))
    for number in range(1, _TICKS):
        now_ns = number * TICK_NS
        percepts: tuple[Percept, ...] = ()
        if number % 5 == 0:
            percepts = (percept_from_scan(points, now_ns, params), _tracks(now_ns))
        inputs = Inputs(
            stamp_ns=now_ns,
            navigation=(_fix(road_map.origin, now_ns), ImuSample(now_ns, 0.0, 0.0)),
            percepts=percepts,
            plans=plans,
            infrastructure=(
                FleetVehicle(now_ns, "fleet-vehicle", Pose2(40.0, 0.0, 0.0), 0.0),
                PedestrianPresence(now_ns, "crossing", 1),
            ),
            messages=messages if number == 5 else (),
            cabin_events=(SeatButton(now_ns, 1),) if number == 10 else (),
            link=LinkState(now_ns, True, 1, 0),
        )
        state, outputs = tick(state, inputs, car)
        plans = tuple(planner(job) for job in outputs.jobs) if planner is not None else ()


def _tracks(now_ns: int) -> TrackPercept:
    """A walking person, a standing person, a parked car and a cyclist."""
    return TrackPercept(
        now_ns,
        np.arange(4, dtype=np.int64),
        np.array([PEDESTRIAN, PEDESTRIAN, VEHICLE, CYCLIST], dtype=np.int64),
        np.array([[15.0, 4.0, 0.0], [12.0, -3.0, 0.0], [20.0, -4.0, 0.0], [25.0, 1.0, 0.0]]),
        np.array([[0.0, -1.2], [0.0, 0.0], [0.0, 0.0], [3.0, 0.0]]),
        np.array([[0.5, 0.5], [0.5, 0.5], [4.5, 1.8], [1.8, 0.6]]),
    )


def straight_road(length_m: float = 100.0) -> RoadMap:
    """A map of one straight lane to the east in two sections, without a way back."""
    points = tuple((float(x), 0.0) for x in range(round(length_m) + 1))
    lane = Lane("east", "road", points, 3.0, 3.0, False, ())
    half_m = 0.5 * length_m
    sections = (Section("east/0", "east", 0.0, half_m), Section("east/1", "east", half_m, length_m))
    place = RestingPlace("rest", "east", length_m - 10.0)
    road_map = RoadMap("warm", "warm", Origin(31.3, 121.4), (lane,), sections, (), (place,))
    return decode_map(encode_map(road_map))


def _with_observation_area(road_map: RoadMap) -> RoadMap:
    outline = ((60.0, -2.0), (64.0, -2.0), (64.0, 2.0), (60.0, 2.0))
    area = ObservationArea("crossing", "crossing", outline, (("east", 59.0),))
    return decode_map(
        encode_map(msgspec.structs.replace(road_map, observation_areas=(area,), map_version=""))
    )


def _order(road_map: RoadMap) -> Order:
    rest = Visit("rest", "rest", "", "east", 80.0, ("east",))
    grants = tuple(SectionGrant(section.section_id, 1) for section in road_map.sections)
    return Order(1, "warm", 1, road_map.map_version, (rest,), grants, 2**62)


def _fix(origin: Origin, now_ns: int) -> GnssFix:
    latitude_deg, longitude_deg = unproject(origin, 20.0, 0.0)
    return GnssFix(now_ns, latitude_deg, longitude_deg, 0.0, 2.0, 0.0, 0.02)
