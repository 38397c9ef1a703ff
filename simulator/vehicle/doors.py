"""A shuttle's doors and what its outside screen and speaker give."""

from vehicle_agent.signals import DoorState, HmiOutput

MOVE_NS = 2_000_000_000
REPEAT_NS = 1_000_000_000
STANDING_MPS = 0.1


class Doors:
    """Open and close in MOVE_NS; they stay shut while the vehicle moves."""

    def __init__(self) -> None:
        self.is_open = False
        self._wanted = False
        self._since_ns = 0
        self._told_ns: int | None = None

    def command(self, wanted_open: bool, now_ns: int) -> None:
        if wanted_open != self._wanted:
            self._wanted, self._since_ns = wanted_open, now_ns

    def step(self, now_ns: int, speed_mps: float) -> DoorState | None:
        """The door switch's word: at every change and once a second."""
        if self._wanted and not self.is_open and abs(speed_mps) > STANDING_MPS:
            self._since_ns = now_ns
        changed = self._wanted != self.is_open and now_ns - self._since_ns >= MOVE_NS
        if changed:
            self.is_open = self._wanted
        if not changed and self._told_ns is not None and now_ns - self._told_ns < REPEAT_NS:
            return None
        self._told_ns = now_ns
        return DoorState(now_ns, self.is_open)


class Display:
    """What people outside read and hear: the last texts, and every announcement in order."""

    def __init__(self) -> None:
        self.says: HmiOutput | None = None
        self.announcements: list[tuple[int, str, str]] = []

    def show(self, says: HmiOutput, now_ns: int) -> None:
        """Each new announcement is spoken once, as long as it stays the same."""
        spoken = self.says.announce if self.says is not None else ""
        if says.announce and says.announce != spoken:
            self.announcements.append((now_ns, says.announce, says.announce_zh))
        self.says = says
