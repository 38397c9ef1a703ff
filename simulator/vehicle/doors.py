"""A shuttle's doors, outside screen and loudspeaker."""

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
        self._reported_ns: int | None = None

    def command(self, wanted_open: bool, now_ns: int) -> None:
        if wanted_open != self._wanted:
            self._wanted, self._since_ns = wanted_open, now_ns

    def step(self, now_ns: int, speed_mps: float) -> DoorState | None:
        """The door sensor's report, at every change and once a second."""
        if self._wanted and not self.is_open and abs(speed_mps) > STANDING_MPS:
            self._since_ns = now_ns
        changed = self._wanted != self.is_open and now_ns - self._since_ns >= MOVE_NS
        if changed:
            self.is_open = self._wanted
        if not changed and self._reported_ns is not None and now_ns - self._reported_ns < REPEAT_NS:
            return None
        self._reported_ns = now_ns
        return DoorState(now_ns, self.is_open)


class Display:
    """The outside screen's last output, and all announcements in order."""

    def __init__(self) -> None:
        self.output: HmiOutput | None = None
        self.announcements: list[tuple[int, str, str]] = []

    def show(self, output: HmiOutput, now_ns: int) -> None:
        """Show an output; an announcement is spoken once until it changes."""
        spoken = self.output.announce if self.output is not None else ""
        if output.announce and output.announce != spoken:
            self.announcements.append((now_ns, output.announce, output.announce_zh))
        self.output = output
