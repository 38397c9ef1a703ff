"""The campus as data: one versioned, immutable road map.

Everything is in the map frame: metres east (x) and north (y) of the origin, on the local tangent plane.
A lane's reference line is the path of a vehicle's **rear-axle centre**.
"""

from typing import Literal

import msgspec

Point = tuple[float, float]
LaneKind = Literal["road", "turn", "turnaround"]
AreaKind = Literal["intersection", "crossing"]
SignKind = Literal["stop", "yield"]
Scenario = Literal["common_road", "parking_lot", "unprotected_intersection"]
SCENARIOS: tuple[Scenario, ...] = ("common_road", "parking_lot", "unprotected_intersection")

FORMAT_VERSION = 1


# Of ids and names; the wire carries them.
NAME_CHARACTERS_MAX = 200


class Origin(msgspec.Struct, frozen=True):
    """The map frame's origin on WGS 84; x points east, y north there."""

    latitude_deg: float
    longitude_deg: float


class Lane(msgspec.Struct, frozen=True):
    """One direction of travel between two places where a choice can be made.

    points      reference line, at most 1 m apart, at least two
    can_pass    two shuttles can meet on this lane's road without one of them waiting
    successors  lanes that begin where, and in the direction in which, this one ends
    """

    lane_id: str
    kind: LaneKind
    points: tuple[Point, ...]
    width_m: float
    speed_limit_mps: float
    can_pass: bool
    successors: tuple[str, ...]
    scenario: Scenario = "common_road"
    name: str = ""
    name_en: str = ""


class Section(msgspec.Struct, frozen=True):
    """A piece of one lane that one shuttle at a time may occupy.

    Every lane is tiled by its sections. A shuttle in this section excludes every other shuttle from this
    section and from each of `conflicts`: the opposite direction of a road too narrow to pass on, the
    crossing and merging turns of a junction. The relation is symmetric.
    """

    section_id: str
    lane_id: str
    s_from_m: float
    s_to_m: float
    conflicts: tuple[str, ...] = ()


class Stop(msgspec.Struct, frozen=True):
    """Where riders board and alight: the rear axle stands at s_m on the lane."""

    stop_id: str
    name: str
    lane_id: str
    s_m: float
    name_en: str = ""
    placed_by: Literal["tag", "rule", "hand"] = "tag"


class RestingPlace(msgspec.Struct, frozen=True, omit_defaults=True):
    """Where a shuttle may stand for as long as it likes.

    charger  a shuttle that stands here is charged; where no place of a map says so, all of them charge

    With a shuttle at every resting place of the map at once, every stop can still be reached from every
    resting place and the other way round. This is what makes the fleet free of deadlock
    (docs/contract/roads.md).
    """

    place_id: str
    lane_id: str
    s_m: float
    charger: bool = False


class Building(msgspec.Struct, frozen=True):
    """An obstacle for the simulator's lidar: an outline (closed implicitly) and a height."""

    outline: tuple[Point, ...]
    height_m: float
    name: str = ""


class ObservationArea(msgspec.Struct, frozen=True):
    """Ground to be observed before a vehicle drives past its stop lines.

    outline     closed implicitly, does not cross itself. Of an intersection: the junction and the last metres
                of every way into it; of a crossing: the road there and 2 m of pavement on each side
    stop_lines  (lane_id, s_m): where the front bumper stands clear of crossing people
    """

    area_id: str
    kind: AreaKind
    outline: tuple[Point, ...]
    stop_lines: tuple[tuple[str, float], ...]


class NoStoppingZone(msgspec.Struct, frozen=True):
    """A stretch of one lane where no rider gets in or out: no stop, no resting place, no stop on request.

    s_from_m, s_to_m  between which the body must not stand; a shuttle that has to wait may still do so
    """

    zone_id: str
    lane_id: str
    s_from_m: float
    s_to_m: float


class Kerb(msgspec.Struct, frozen=True):
    """The edge of what can be driven on: a line that no body may cross; points in the map frame."""

    kerb_id: str
    points: tuple[Point, ...]


class RoadSign(msgspec.Struct, frozen=True, omit_defaults=True):
    """A traffic sign for the vehicles of one lane, which stands beside it.

    s_m     of the stop line: where the front bumper stands
    side    of the lane; signs stand on the side of the kerb

    No vehicle takes a sign from the map: it must see the board (docs/decisions/0035).
    """

    sign_id: str
    kind: SignKind
    lane_id: str
    s_m: float
    side: Literal["left", "right"] = "right"


class TimetableTrip(msgspec.Struct, frozen=True, omit_defaults=True):
    """One scheduled run: a departure (seconds after local midnight) at each of its stops, in order.

    service_id  whose calendar says on which days it runs; "" for every day that is no holiday
    """

    trip_id: str
    calls: tuple[tuple[str, int], ...]
    service_id: str = ""


class RoadMap(msgspec.Struct, frozen=True):
    """A campus map; `map_version` is the content's hash, set by `contract.roads.load`.

    observation_areas, no_stopping_zones, kerbs, signs  not written when there are none: maps made before
                       there were any keep their version
    """

    campus_id: str
    name: str
    origin: Origin
    lanes: tuple[Lane, ...]
    sections: tuple[Section, ...]
    stops: tuple[Stop, ...]
    resting_places: tuple[RestingPlace, ...]
    buildings: tuple[Building, ...] = ()
    timetable: tuple[TimetableTrip, ...] = ()
    timezone: str = "UTC"
    schematic: bool = False
    attribution: str = ""
    repairs: tuple[str, ...] = ()
    format_version: int = FORMAT_VERSION
    map_version: str = ""
    observation_areas: tuple[ObservationArea, ...] = ()
    no_stopping_zones: tuple[NoStoppingZone, ...] = ()
    kerbs: tuple[Kerb, ...] = ()
    signs: tuple[RoadSign, ...] = ()

    @property
    def charging_places(self) -> tuple[RestingPlace, ...]:
        """The resting places at which shuttles charge."""
        named = tuple(place for place in self.resting_places if place.charger)
        return named or self.resting_places
