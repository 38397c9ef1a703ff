"""A ring road, and a shuttle that obeys the mission perfectly: 0.1 s a step, no rooms but the mission."""

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np

from contract.geometry import Pose2, arc_lengths, pose_at
from contract.roads.load import decode_map, encode_map
from contract.roads.model import Lane, Origin, Point, RestingPlace, RoadMap, Section
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_sections
from contract.wire.messages import (
    Command,
    Grants,
    Order,
    OrderAccepted,
    OrderRejected,
    RiderTask,
    SectionGrant,
    SectionReleased,
    VehicleEvent,
    Visit,
    VisitKind,
)
from vehicle_agent.config import Profile
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.mission.mission import Mission
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import (
    NO_TRACKS,
    CabinEvent,
    DoorState,
    Ego,
    LinkState,
    MissionMessage,
    Task,
    VehicleMotion,
    World,
)
from vehicle_agent.stacks.rooms import mission_rules

STEP_NS = 100_000_000
OFFSET_NS = 1_000_000_000_000
STRAIGHT_M, RADIUS_M = 80.0, 15.0


def ring() -> RoadMap:
    """Anticlockwise: south (east-bound), east turn, north (west-bound), west turn."""
    k = np.linspace(-math.pi / 2, math.pi / 2, 60)
    turn = np.column_stack((RADIUS_M * np.cos(k), RADIUS_M + RADIUS_M * np.sin(k)))
    south = np.column_stack((np.linspace(0, STRAIGHT_M, 81), np.zeros(81)))
    north = np.column_stack((np.linspace(STRAIGHT_M, 0, 81), np.full(81, 2 * RADIUS_M)))
    east, west = turn + np.array([STRAIGHT_M, 0.0]), np.column_stack((-turn[:, 0], 2 * RADIUS_M - turn[:, 1]))
    shapes = {"south": south, "east": east, "north": north, "west": west}
    follows = {"south": "east", "east": "north", "north": "west", "west": "south"}
    lanes, sections = [], []
    for name, shape in shapes.items():
        kind = "road" if name in ("south", "north") else "turn"
        points: tuple[Point, ...] = tuple((float(x), float(y)) for x, y in shape)
        lanes.append(Lane(name, kind, points, 3.0, 3.0, False, (follows[name],)))  # type: ignore[arg-type]
        length = float(arc_lengths(np.array(points))[-1])
        cuts = np.linspace(0.0, length, 5 if kind == "road" else 2)
        sections += [
            Section(f"{name}/{i}", name, float(a), float(b), _conflicts(f"{name}/{i}"))
            for i, (a, b) in enumerate(itertools.pairwise(cuts))
        ]
    places = (RestingPlace("rest", "north", 70.0),)
    raw = RoadMap("ring", "ring", Origin(31.3, 121.4), tuple(lanes), tuple(sections), (), places)
    return decode_map(encode_map(raw))


def _conflicts(section_id: str) -> tuple[str, ...]:
    """The last piece of the south road is crossed by the east turn."""
    return {"south/3": ("east/0",), "east/0": ("south/3",)}.get(section_id, ())


NETWORK = RoadNetwork(ring())
ROOM = Mission(NETWORK, mission_rules(Profile()))
START = ("south", 5.0)


def a_visit(
    name: str,
    lane: str,
    s_m: float,
    after: tuple[str, float] = START,
    kind: VisitKind = "stop",
    board: Sequence[RiderTask] = (),
    alight: Sequence[RiderTask] = (),
    dwell_s: float = 5.0,
    not_before_ns: int = 0,
    timed: bool = False,
) -> Visit:
    route = find_route(NETWORK, *after, lane, s_m)
    assert route is not None
    return Visit(
        name,
        kind,
        name,
        lane,
        s_m,
        route.lane_ids,
        tuple(board),
        tuple(alight),
        dwell_s,
        not_before_ns,
        timed,
        name,
    )


def all_sections(visits: Sequence[Visit], start: tuple[str, float] = START) -> tuple[SectionGrant, ...]:
    found: list[str] = []
    here = start
    for visit in visits:
        route = find_route(NETWORK, *here, visit.lane_id, visit.s_m)
        assert route is not None
        found += [s for s in route_sections(NETWORK, route) if not found or found[-1] != s]
        here = (visit.lane_id, visit.s_m)
    found += [s.section_id for s in NETWORK.sections_of(here[0]) if s.s_from_m > here[1]]
    return tuple(SectionGrant(section_id, i + 1) for i, section_id in enumerate(found))


def an_order(
    visits: Sequence[Visit],
    revision: int = 1,
    order_id: str = "o",
    sections: tuple[SectionGrant, ...] | None = None,
    expires_ns: int = 10**18,
    map_version: str = NETWORK.map_version,
) -> Order:
    grants = all_sections(visits) if sections is None else sections
    return Order(1, order_id, revision, map_version, tuple(visits), grants, expires_ns)


def rest(after: tuple[str, float], name: str = "rest") -> Visit:
    return a_visit(name, "north", 70.0, after, "rest", dwell_s=0.0)


class RingShuttle:
    """events and answers are everything it has said; points, tracks and occupied_stops: what it sees."""

    def __init__(self, memory: MissionMemory | None = None, start: tuple[str, float] = START) -> None:
        self.pose = Pose2(*NETWORK.pose(*start))
        self.state: MissionState = ROOM.initial(memory)
        self.now_ns, self.speed_mps = 0, 0.0
        self.events: list[VehicleEvent] = []
        self.answers: list[OrderAccepted | OrderRejected] = []
        self.points = np.empty((0, 2))
        self.tracks = NO_TRACKS
        self.stops_short_m = 0.0
        self.occupied_stops: tuple[str, ...] = ()
        self.valid, self.door_sensor, self.doors_open = True, True, False
        self.grants_follow = True
        self.task: Task | None = None

    def step(self, *said: MissionMessage | CabinEvent) -> Task:
        self.now_ns += STEP_NS
        words = tuple(s for s in said if isinstance(s, MissionMessage))
        pressed = tuple(s for s in said if not isinstance(s, MissionMessage))
        if self.door_sensor:
            pressed = (DoorState(self.now_ns, self.doors_open), *pressed)
        ego = Ego(self.now_ns, self.pose, self.speed_mps, 0, 0, 0, 0.02, self.now_ns, self.valid)
        motion = VehicleMotion(self.now_ns, self.speed_mps, 0, 0, 0, True, False, True, 1.0)
        world = World(
            self.now_ns,
            self.now_ns,
            self.points,
            (),
            (),
            False,
            self.tracks,
            occupied_stops=self.occupied_stops,
        )
        link = LinkState(self.now_ns, True, 1, OFFSET_NS)
        task, self.state = ROOM.step(self.state, words, pressed, link, ego, motion, world, self.now_ns)
        self.events += ROOM.events(self.state)
        self.answers += ROOM.answers(self.state)
        self.doors_open = task.doors_open
        self.task = task
        self._drive(task)
        return task

    def _drive(self, task: Task) -> None:
        left_m = task.stop_s_m - task.s_m - self.stops_short_m
        moving = (
            task.mode in ("drive", "hold")
            and left_m > 0.02
            and task.line is not None
            and not (task.mode == "hold" and self.speed_mps == 0.0)
        )
        self.speed_mps = min(3.0, self.speed_mps + 0.1, math.sqrt(1.2 * left_m)) if moving else 0.0
        if moving and task.line is not None:
            ahead_m = min(self.speed_mps * STEP_NS * 1e-9, left_m)
            self.pose = Pose2(*pose_at(task.line.points, task.line.s, task.s_m + ahead_m))

    def run(self, seconds: float) -> None:
        """Drive; the server takes released sections back."""
        for _ in range(round(seconds * 1e9 / STEP_NS)):
            released = [e for e in ROOM.events(self.state) if isinstance(e, SectionReleased)]
            order = self.state.memory.order
            if released and order is not None and self.grants_follow:
                self.step(Grants(1, order.order_id, self.state.memory.grants))
            else:
                self.step()

    def run_until(self, condition: Callable[[], bool], limit_s: float = 300.0) -> None:
        """Drive as `run` does; AssertionError when the condition does not hold after limit_s."""
        until_ns = self.now_ns + round(limit_s * 1e9)
        while not condition():
            assert self.now_ns < until_ns, f"not after {limit_s} s: {self.state.stage}"
            self.run(STEP_NS * 1e-9)

    def go(self, order: Order) -> None:
        self.step()
        self.step(order)
        self.step(Command(1, f"go-{self.now_ns}", "resume"))

    def of(self, kind: type) -> list[VehicleEvent]:
        return [event for event in self.events if isinstance(event, kind)]
