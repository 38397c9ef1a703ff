"""A snapshot of the dispatcher's problem: flat, immutable, and without a clock.

Places are numbers: rows of the travel-time table. Times are seconds on one axis (the caller's choice, here
the Unix epoch), so that a snapshot can be stored and solved again.
"""

import math
from dataclasses import dataclass, field

from contract.geometry import Array

# Driving that no road allows. Finite, so that sums and differences of it stay numbers; no window is so long.
CUT_OFF_S = 1e7


@dataclass(frozen=True, slots=True)
class Walk:
    """Another stop that a party could walk from or to, and the seconds that takes."""

    place: int
    walk_s: float


@dataclass(frozen=True, slots=True)
class Plane:
    """Places on an open plane, where driving takes `slowness` seconds per unit of distance.

    xy  (P, 2) of each place
    """

    xy: Array
    slowness: float


@dataclass(frozen=True, slots=True)
class Request:
    """A party to be carried. Windows are hard: a solution that breaks one is none.

    pickup_from_s, pickup_to_s  the vehicle comes to the pickup within these
    arrive_by_s  it comes to the drop-off no later
    arrive_from_s  nor any earlier
    ride_s_max   longest time between the end of boarding and coming to the drop-off
    dwell_s      how long they take to board, and to alight; None for the problem's dwell
    pinned       it stays with the vehicle that has it: no improvement gives it to another one
    travel_time_factor  what driving to either stop takes at that hour, over the table's time
    pickup_walks, dropoff_walks  other possible stops; the walk makes the pickup later and the latest
                 drop-off earlier
    """

    request_id: str
    pickup: int
    dropoff: int
    party: int
    wheelchairs: int
    pickup_from_s: float
    pickup_to_s: float
    arrive_by_s: float
    ride_s_max: float = math.inf
    pickup_walks: tuple[Walk, ...] = ()
    dropoff_walks: tuple[Walk, ...] = ()
    arrive_from_s: float = -math.inf
    dwell_s: float | None = None
    pinned: bool = False
    travel_time_factor: float = 1.0


@dataclass(frozen=True, slots=True)
class Call:
    """One visit of a route.

    call_id      the caller's name for it, "" for one that the solver made
    board, alight  request ids
    leave_from_s  the vehicle leaves no earlier (a timetable departure)
    arrive_by_s  it arrives no later
    fixed        it stays even if no rider boards or alights
    travel_time_factor  what driving to it takes at that hour, over the table's time: that of the rider for
                 whom it was made, so that it does not depend on the order of its riders
    off_duty     it stands for the time between two shifts, and is left out of the routes that are decided
    """

    place: int
    board: tuple[str, ...] = ()
    alight: tuple[str, ...] = ()
    dwell_s: float = 0.0
    leave_from_s: float = -math.inf
    arrive_by_s: float = math.inf
    fixed: bool = False
    call_id: str = ""
    travel_time_factor: float = 1.0
    off_duty: bool = False


@dataclass(frozen=True, slots=True)
class CallTime:
    """When a call is made under the plan."""

    arrive_s: float
    leave_s: float


@dataclass(frozen=True, slots=True)
class Chain:
    """Calls that one vehicle makes in this order, others between them allowed: a timetable departure."""

    chain_id: str
    calls: tuple[Call, ...]


@dataclass(frozen=True, slots=True)
class VehicleState:
    """A vehicle at the moment of the snapshot.

    to_places_s  (P,) seconds from where it is to every place; empty on a plane
    ready_s      when it can drive to its next call
    aboard       requests in the vehicle now
    calls        its present route, resting left out
    locked       so many leading calls stay as they are (it stands at the first one)
    accepts      new requests may be given to it
    on_duty_to_s when its shift ends: its last call is left by then
    drive_s_max  driving that its battery allows above the reserve
    at_xy        where it is on a plane
    ends_at      the place to which it returns after its last call, -1 for anywhere
    duty_s_max   longest time from leaving where it is now to its end
    """

    vehicle_id: str
    to_places_s: Array
    ready_s: float
    seats: int
    wheelchair_places: int
    aboard: tuple[str, ...] = ()
    calls: tuple[Call, ...] = ()
    locked: int = 0
    accepts: bool = True
    on_duty_to_s: float = math.inf
    drive_s_max: float = math.inf
    at_xy: tuple[float, float] = (0.0, 0.0)
    ends_at: int = -1
    duty_s_max: float = math.inf


@dataclass(frozen=True, slots=True)
class CostWeights:
    """What a second is worth. Driving counts as cost; waiting, walking and riding for each person.

    late  each second that a timetable call is left late; so high that another vehicle rather drives far
    """

    drive: float = 1.0
    wait: float = 0.5
    walk: float = 0.75
    ride: float = 0.25
    late: float = 20.0


@dataclass(frozen=True, slots=True)
class Problem:
    """What is to be decided.

    times         (P, P) planned seconds between places; infinite where no road leads; empty on a plane
    requests      every request named anywhere, by id
    open_requests, open_chains  those without a vehicle, in the order in which they are inserted
    dwell_s       how long a call made for a request lasts
    together      riders board and alight at one place at the same time
    """

    vehicles: tuple[VehicleState, ...]
    requests: dict[str, Request]
    times: Array
    open_requests: tuple[str, ...] = ()
    open_chains: tuple[Chain, ...] = ()
    dwell_s: float = 0.0
    weights: CostWeights = field(default_factory=CostWeights)
    plane: Plane | None = None
    together: bool = True


@dataclass(frozen=True, slots=True)
class VehicleRoute:
    """A vehicle's calls in order, each with its times."""

    vehicle_id: str
    calls: tuple[Call, ...]
    times: tuple[CallTime, ...]
