"""Roads that operators have closed: lanes or single sections, for a time or until further notice."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime
from enum import StrEnum

from server.domain.errors import ClosureInvalid, ClosureOver


class ClosureState(StrEnum):
    """scheduled: its time has not come; over: its time has passed, or it was lifted."""

    SCHEDULED = "scheduled"
    IN_FORCE = "in_force"
    OVER = "over"


@dataclass(frozen=True, slots=True)
class Closure:
    """No vehicle is sent through these lanes and sections within [starts_at, ends_at).

    ends_at     None: until it is lifted
    lifted_by   the operator who ended it, "" for one whose time has passed
    """

    campus_id: str
    closure_id: str
    lane_ids: tuple[str, ...]
    section_ids: tuple[str, ...]
    reason: str
    starts_at: datetime
    ends_at: datetime | None
    made_by: str
    made_at: datetime
    state: ClosureState = ClosureState.SCHEDULED
    lifted_by: str = ""

    @property
    def label(self) -> str:
        """Its name in incidents."""
        return f"closure {self.closure_id}" + (f" ({self.reason})" if self.reason else "")

    def overlaps(self, begins: datetime, ends: datetime) -> bool:
        """It is not over, and is in force at some time within [begins, ends]."""
        stands = self.state is not ClosureState.OVER
        return stands and self.starts_at <= ends and (self.ends_at is None or begins < self.ends_at)


def require_sound(closure: Closure) -> None:
    """Raises ClosureInvalid."""
    if not closure.lane_ids and not closure.section_ids:
        raise ClosureInvalid("name a lane or a section to close")
    if closure.ends_at is not None and closure.ends_at <= closure.starts_at:
        raise ClosureInvalid("the closure ends before it begins")
    if closure.ends_at is not None and closure.ends_at <= closure.made_at:
        raise ClosureInvalid("the end of the closure has passed; give it a later end, or none")


def due(closure: Closure, now: datetime) -> Closure:
    """The closure in its state at this moment."""
    if closure.state is ClosureState.OVER or now < closure.starts_at:
        return closure
    over = closure.ends_at is not None and closure.ends_at <= now
    state = ClosureState.OVER if over else ClosureState.IN_FORCE
    return closure if state is closure.state else replace(closure, state=state)


def lifted(closure: Closure, by: str) -> Closure:
    """Raises ClosureOver."""
    if closure.state is ClosureState.OVER:
        raise ClosureOver(f"closure {closure.closure_id} is over already")
    return replace(closure, state=ClosureState.OVER, lifted_by=by)


def ends_of(closures: Iterable[Closure]) -> list[datetime]:
    """The moments at which one of them ends by itself, in order."""
    return sorted({closure.ends_at for closure in closures if closure.ends_at is not None})
