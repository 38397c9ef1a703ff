"""Decisions of the dispatcher, stored so that they can be explained and repeated bit for bit."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

DecisionKind = Literal["booking", "change", "reassignment", "improvement"]


@dataclass(frozen=True, slots=True)
class Quote:
    """A ride as one shuttle would make it.

    extra_cost_s  what it costs the whole fleet's plan, in weighted seconds of driving, waiting and riding
    """

    vehicle_id: str
    extra_cost_s: float
    pickup_at: datetime
    arrival_at: datetime


@dataclass(frozen=True, slots=True)
class Alternative:
    """What would have been accepted instead of a refused ride: one or two rides.

    parties  people in each ride; pickup_at, arrival_at: of each as planned
    walk_s   to the pickup and from the drop-off, compared with the requested stops
    """

    kind: Literal["later", "other_stops", "split_party"]
    from_stop: str
    to_stop: str
    parties: tuple[int, ...]
    walk_s: float
    pickup_at: tuple[datetime, ...]
    arrival_at: tuple[datetime, ...]


@dataclass(frozen=True, slots=True)
class RideDecision:
    """Why a ride got the shuttle it has, or none.

    rule      that binds, "" for a ride that was taken
    runner_up the best that any other shuttle offered
    vehicles  that were considered
    """

    campus_id: str
    ride_id: str
    decision_id: str
    made_at: datetime
    rule: str
    best: Quote | None
    runner_up: Quote | None
    alternatives: tuple[Alternative, ...]
    vehicles: int


@dataclass(frozen=True, slots=True)
class Decision:
    """A snapshot of the fleet and the decision made from it.

    problem   the snapshot as `dispatch.problem_codec` writes it
    given     what else the answer depends on; answer: what came out: both JSON, compared when it is repeated
    """

    campus_id: str
    decision_id: str
    made_at: datetime
    kind: DecisionKind
    problem: bytes
    given: bytes
    answer: bytes
