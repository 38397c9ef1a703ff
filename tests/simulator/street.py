"""A straight street 600 m long, as a road map, for worlds in tests."""

from contract.geometry import Pose2
from contract.roads.load import with_version
from contract.roads.model import Building, Lane, Origin, RestingPlace, RoadMap, Section, Stop
from simulator.world import SimWorld, WorldOptions
from vehicle_agent.config import Profile

LENGTH_M = 600


def street(buildings: tuple[Building, ...] = ()) -> RoadMap:
    points = tuple((float(x), 0.0) for x in range(LENGTH_M + 1))
    lane = Lane("east", "road", points, 4.0, 4.0, False, ())
    return with_version(
        RoadMap(
            "test",
            "Street",
            Origin(31.3, 121.4),
            (lane,),
            (Section("east-1", "east", 0.0, float(LENGTH_M)),),
            (Stop("a", "A", "east", 20.0), Stop("b", "B", "east", 560.0)),
            (RestingPlace("rest-1", "east", 10.0), RestingPlace("rest-2", "east", 590.0)),
            buildings,
        )
    )


class QuietPhone:
    """Shows every rider the same vehicle and remembers the taps."""

    def __init__(self, vehicle_id: str = "s1") -> None:
        self.vehicle_id = vehicle_id
        self.taps: list[tuple[str, str]] = []

    def vehicle_of(self, ride_id: str) -> str:
        return self.vehicle_id

    def tap(self, ride_id: str, kind: str) -> None:
        self.taps.append((ride_id, kind))


def a_world(
    options: WorldOptions, *, seed: int = 1, x_m: float = 20.0, phone: QuietPhone | None = None
) -> SimWorld:
    """One vehicle, `s1`, on the street."""
    poses = {"s1": Pose2(x_m, 0.0, 0.0)}
    return SimWorld(street(), {"s1": Profile()}, poses, seed, phone or QuietPhone(), options)
