"""Which refused hellos are entered in the audit log: enough to see an attack, too few to fill a disk with."""

from server.domain.record.audit import AuditAction, Caller
from server.usecases.ports.clock_and_ids import Clock

# The same vehicle name from the same address is entered once in this time.
EVERY_S = 60.0
# Of all names and addresses together, in the same time.
ENTRIES_MAX = 20


class RefusedHellos:
    """Of one server. What is left out is counted in the next entry."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._entered: dict[tuple[str, str, str], float] = {}
        self._left_out = 0

    def entry(self, vehicle_id: str, address: str, code: str) -> tuple[Caller, AuditAction] | None:
        """What to append; None if enough is there. The name is the stranger's word: nothing proves it."""
        now_s = self._clock.now().timestamp()
        # A clock that was set back would keep entries for ever.
        self._entered = {key: at_s for key, at_s in self._entered.items() if 0.0 <= now_s - at_s < EVERY_S}
        key = (vehicle_id, address, code)
        if key in self._entered or len(self._entered) >= ENTRIES_MAX:
            self._left_out += 1
            return None
        self._entered[key] = now_s
        left_out, self._left_out = self._left_out, 0
        detail = f"{left_out} refused hellos before it are not entered" if left_out else ""
        return Caller("unknown", "", address), AuditAction("open_session", vehicle_id, detail, code)
