"""Hard brakings of vehicles, as their statuses tell them: who brakes, once for each braking."""

from datetime import datetime, timedelta
from typing import Literal, NamedTuple

from contract.wire.messages import DriveMode
from server.domain.fleet.vehicles import StatusReport

Braking = Literal["guard", "planner", "driver"]

# No plan asks for harder braking but to avoid a contact.
HARD_MPS2 = -2.0
# The guard brakes for a contact ahead, as hard as it takes.
CONTACT = "obstacle"
# A braking that begins again within this time is the same one.
SAME_WITHIN = timedelta(seconds=2)
# The guard's own acts, and those in which it does what the planner or the gate has asked for.
_NOT_OF_GUARD = ("", "emergency")


class HardBraking(NamedTuple):
    vehicle_id: str
    at: datetime
    by: Braking


class BrakingWatch:
    """Sees every status of the vehicles that are linked here."""

    def __init__(self) -> None:
        self._braked_at: dict[str, datetime] = {}

    def note(self, report: StatusReport) -> HardBraking | None:
        """The braking that begins with this status."""
        status = report.status
        # The gate's brakings are faults of their own.
        if any(fault.code.startswith("gate_braking_") for fault in status.faults):
            return None
        guard = "" if status.driving is None else status.driving.guard
        if status.accel_mps2 > HARD_MPS2 and guard != CONTACT:
            return None
        before = self._braked_at.get(report.vehicle_id)
        self._braked_at[report.vehicle_id] = report.received_at
        if before is not None and report.received_at - before <= SAME_WITHIN:
            return None
        return HardBraking(report.vehicle_id, report.received_at, _braking_of(status.mode, guard))


def _braking_of(mode: DriveMode, guard: str) -> Braking:
    if mode == "manual":
        return "driver"
    return "planner" if guard in _NOT_OF_GUARD else "guard"
