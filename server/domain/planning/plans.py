"""Plans: a vehicle's visits in driving order, with a resting place of its own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Literal

from contract.wire.messages import VisitKind, VisitState
from server.domain.errors import IllegalTransition

# Why a shuttle goes to another resting place than the one at hand.
RestReason = Literal["", "charge", "demand"]

# `under_way` means that the vehicle stands at the place; driving towards it is still `pending`.
VISIT_TRANSITIONS: Mapping[VisitState, frozenset[VisitState]] = {
    "pending": frozenset({"under_way", "done", "skipped"}),
    "under_way": frozenset({"done", "skipped"}),
    "done": frozenset(),
    "skipped": frozenset(),
}


@dataclass(frozen=True, slots=True)
class PlannedVisit:
    """Go to a place and stand there.

    stop_id     "" for a place that is no stop of the map
    board, alight  ride ids
    not_before  the vehicle does not leave earlier; latest: it should have arrived by then
    eta         arrival as planned now
    departure_id, call  the timetable departure and its call that this visit makes, "" and 0 for none
    why         a rest is made to charge, or where riders are expected; "" for the nearest place
    """

    visit_id: str
    kind: VisitKind
    stop_id: str
    lane_id: str
    s_m: float
    board: tuple[str, ...] = ()
    alight: tuple[str, ...] = ()
    dwell_s: float = 15.0
    not_before: datetime | None = None
    latest: datetime | None = None
    eta: datetime | None = None
    state: VisitState = "pending"
    departure_id: str = ""
    call: int = 0
    why: RestReason = ""

    @property
    def is_open(self) -> bool:
        return self.state in ("pending", "under_way")


@dataclass(frozen=True, slots=True)
class Plan:
    """One vehicle's open visits in driving order; visits done or skipped are left out.

    The first stops are followed by a rest: so far its order goes. Later stops come after it, and when a stop
    is done the rest moves on behind the next one. A vehicle that cannot go on yet thus has a place to wait.

    version    raised by every change; a writer states the version it read (compare and set)
    resting_place_id  where its rest visit is, this vehicle's alone; "" while it has none
    """

    campus_id: str
    vehicle_id: str
    version: int
    visits: tuple[PlannedVisit, ...] = ()
    resting_place_id: str = ""

    def visit(self, visit_id: str) -> PlannedVisit | None:
        return next((visit for visit in self.visits if visit.visit_id == visit_id), None)

    @property
    def ordered(self) -> tuple[PlannedVisit, ...]:
        """What its order holds: everything up to and including the next rest that is still ahead."""
        for number, visit in enumerate(self.visits):
            if visit.kind == "rest" and visit.state == "pending":
                return self.visits[: number + 1]
        return ()

    @property
    def under_way(self) -> PlannedVisit | None:
        """The visit at whose place the vehicle stands, if it stands at one."""
        return next((visit for visit in self.visits if visit.state == "under_way"), None)

    @property
    def ride_ids(self) -> tuple[str, ...]:
        """Every ride that some visit boards or alights, in driving order, each once."""
        found: dict[str, None] = {}
        for visit in self.visits:
            found.update(dict.fromkeys((*visit.board, *visit.alight)))
        return tuple(found)


def next_version(plan: Plan, visits: Sequence[PlannedVisit], resting_place_id: str | None = None) -> Plan:
    """The plan with other visits, one version on."""
    return replace(
        plan,
        version=plan.version + 1,
        visits=tuple(visit for visit in visits if visit.is_open),
        resting_place_id=plan.resting_place_id if resting_place_id is None else resting_place_id,
    )


def with_visit_state(plan: Plan, visit_id: str, state: VisitState) -> Plan:
    """The plan after a vehicle's report on a visit; the same plan if nothing changes.

    Visits before one that is under way, done or skipped are completed and are left out. A report on a visit
    that the plan no longer has changes nothing. Raises IllegalTransition for a visit going backwards.
    """
    index = next((i for i, visit in enumerate(plan.visits) if visit.visit_id == visit_id), None)
    if index is None or plan.visits[index].state == state:
        return plan
    visit = plan.visits[index]
    if state not in VISIT_TRANSITIONS[visit.state]:
        raise IllegalTransition(f"visit {visit_id} is {visit.state} and cannot become {state}")
    return next_version(plan, (replace(visit, state=state), *plan.visits[index + 1 :]))
