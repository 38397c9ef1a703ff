"""The facts of a history, from clients, vehicles and the store. Times in seconds since its beginning."""

from collections import deque
from dataclasses import dataclass
from hashlib import sha256

LINES_KEPT = 400


@dataclass(frozen=True, slots=True)
class Violation:
    """rule: its name; subject: the ride, vehicle or task that it was broken for."""

    at_s: float
    rule: str
    subject: str
    text: str


@dataclass(frozen=True, slots=True)
class AcknowledgedBooking:
    """A booking that the server answered with a ride. key: the client's idempotency key."""

    at_s: float
    key: str
    ride_id: str
    party: int = 1


@dataclass(frozen=True, slots=True)
class StoredRide:
    """A ride as the store has it.

    has_ended     completed, cancelled, refused, no-show or failed
    reason        why it did not complete
    due_s         the latest arrival that was promised, or the earliest pickup where nothing is promised
    """

    ride_id: str
    state: str
    has_ended: bool
    reason: str
    vehicle_id: str | None
    party: int
    due_s: float


@dataclass(frozen=True, slots=True)
class VehicleFact:
    """What a vehicle itself saw of a ride: "boarded" or "alighted"."""

    at_s: float
    vehicle_id: str
    ride_id: str
    what: str


@dataclass(frozen=True, slots=True)
class TaskFact:
    """A standing task at the end. idle_s: since its last good cycle; None for one that waits for messages."""

    name: str
    is_running: bool
    failures: int
    idle_s: float | None
    period_s: float


class Journal:
    """Everything that happened, one line each: a digest of all lines, and the last lines for a report."""

    def __init__(self) -> None:
        self.lines = 0
        self._digest = sha256()
        self._last: deque[str] = deque(maxlen=LINES_KEPT)

    def note(self, at_s: float, subject: str, what: str) -> None:
        line = f"{at_s:.3f} {subject} {what}"
        self.lines += 1
        self._digest.update(line.encode() + b"\n")
        self._last.append(line)

    def digest(self) -> str:
        return self._digest.hexdigest()

    def about(self, subject: str, limit: int = 12) -> list[str]:
        """The last lines that name the subject, oldest first."""
        return [line for line in self._last if subject in line][-limit:]
