"""A snapshot of what the dispatcher decides on: flat, immutable, and without a clock.

Places are numbers: rows of the travel-time table. Times are seconds on one axis (the caller's choice, here
the Unix epoch), so that a snapshot can be stored and solved again.
"""

import math
from dataclasses import dataclass, field

from contract.geometry import Array


@dataclass(frozen=True, slots=True)
class Request:
    """A party to be carried. Windows are hard: a solution that breaks one is none.

    ride_s_max   longest time between leaving the pickup place and arriving
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


@dataclass(frozen=True, slots=True)
class Call:
    """One visit of a route.

    call_id      the caller's name for it, "" for one that the solver made
    board, alight  request ids
    leave_from_s  the vehicle leaves no earlier (a timetable departure)
    arrive_by_s  it arrives no later
    fixed        it stays even where nobody boards or alights
    """

    place: int
    board: tuple[str, ...] = ()
    alight: tuple[str, ...] = ()
    dwell_s: float = 0.0
    leave_from_s: float = -math.inf
    arrive_by_s: float = math.inf
    fixed: bool = False
    call_id: str = ""


@dataclass(frozen=True, slots=True)
class Chain:
    """Calls that one vehicle makes in this order, others between them allowed: a timetable departure."""

    chain_id: str
    calls: tuple[Call, ...]


@dataclass(frozen=True, slots=True)
class VehicleState:
    """A vehicle at the moment of the snapshot.

    start, ready_s  the place from which, and the time at which, it can drive to its next call
    aboard       requests in the vehicle now
    calls        its present route, resting left out
    locked       so many leading calls stay as they are (it stands at the first one)
    accepts      new requests may be given to it
    times        (n, n) seconds between places for this vehicle; row `start` is its own position
    """

    vehicle_id: str
    start: int
    ready_s: float
    seats: int
    wheelchair_places: int
    times: Array
    aboard: tuple[str, ...] = ()
    calls: tuple[Call, ...] = ()
    locked: int = 0
    accepts: bool = True


@dataclass(frozen=True, slots=True)
class CostWeights:
    """What a second is worth. Driving counts as cost; waiting and riding count for each person.

    late  a second after its time at which a timetable call is left: rather another vehicle drives far
    """

    drive: float = 1.0
    wait: float = 0.5
    ride: float = 0.25
    late: float = 20.0


@dataclass(frozen=True, slots=True)
class Problem:
    """What is to be decided.

    requests      every request named anywhere, by id
    open_requests, open_chains  those that nobody carries yet, in the order in which they are served
    dwell_s       how long a call made for a request lasts
    """

    vehicles: tuple[VehicleState, ...]
    requests: dict[str, Request]
    open_requests: tuple[str, ...] = ()
    open_chains: tuple[Chain, ...] = ()
    dwell_s: float = 0.0
    weights: CostWeights = field(default_factory=CostWeights)
