"""The second layer of safety: between the tick and the CAN bus, and the only owner of the bus.

Small enough to read aloud. It knows nothing of roads or plans: fresh, consistent commands within the limits
pass; silence, a clock that jumps, a wheel that does not follow, a speed that cannot be, or something
before the bumper that nobody brakes for, are answered with the gate's own brake sequence. That goes on until
the vehicle stands and the tick asks for by-wire anew in two frames, which takes an operator's resume.
"""

from vehicle_agent.can.braking import ByWireBraking, CommandedActuation, CommandSetError
from vehicle_agent.can.by_wire import braking_of, motion_reports_of
from vehicle_agent.can.gate_report import GateCause, gate_report
from vehicle_agent.can.motion_reports import MotionReports
from vehicle_agent.config import Profile
from vehicle_agent.gate.checks import CommandChecks
from vehicle_agent.gate.monitors import FootprintMonitor, SpeedMonitor, SteeringMonitor
from vehicle_agent.gate.settings import GateSettings, gate_settings
from vehicle_agent.signals import CanFrame, Percept, VehicleMotion

_SAYS: dict[GateCause, str] = {
    "tick_late": "the tick is silent",
    "module_lost": "the module is silent",
    "clock_jumped": "the clock jumped",
    "footprint": "something before the bumper",
    "too_fast": "too fast",
    "steering_stuck": "the steering does not follow",
}


class Gate:
    """refused: why the last set of commands was not let through, empty when it was.
    cause: why the gate itself brakes, None when it does not; braking: the same in words, or empty."""

    def __init__(self, by_wire: ByWireBraking, reports: MotionReports, settings: GateSettings) -> None:
        self._by_wire, self._settings = by_wire, settings
        self._reports = reports
        self._motion: VehicleMotion | None = None
        self._checks = CommandChecks(by_wire, settings)
        self._steering, self._speed = SteeringMonitor(settings), SpeedMonitor(settings)
        self._footprint = FootprintMonitor(settings)
        self.refused, self._refused_then = "", ""
        self.cause: GateCause | None = None
        self._pending: tuple[CanFrame, ...] = ()
        self._last: tuple[CanFrame, ...] = ()
        self._asked: CommandedActuation | None = None
        self._last_ns = 0
        self._stepped_ns = 0
        self._braked_steps = 0
        self._saw_disabled = False
        self._tells = 0

    def hear(self, frames: tuple[CanFrame, ...], now_ns: int) -> None:
        """The module's reports, before they go on to the tick."""
        self._motion = self._reports.decode(frames, now_ns)

    def see(self, percept: Percept) -> None:
        """A perception worker's answer, straight from the worker."""
        self._footprint.see(percept)

    def take(self, frames: tuple[CanFrame, ...], now_ns: int) -> None:
        """One tick's command frames. A set that is inconsistent, old, repeated or beyond the limits is
        refused: a stale command must not look alive."""
        try:
            asked = self._checks.believed(frames, now_ns)
        except CommandSetError as error:
            self.refused = str(error)
            return
        self.refused = ""
        if self.cause is not None and not self._lets_go(asked):
            return
        self.cause = None
        self._last, self._pending, self._asked = frames, frames, asked
        self._last_ns = now_ns
        self._braked_steps = 0

    def step(self, now_ns: int) -> tuple[CanFrame, ...]:
        """Frames for the bus now, called every 20 ms: the tick's, or nothing yet, or the gate's brake."""
        since_ns = now_ns - self._stepped_ns if self._stepped_ns else 0
        self._stepped_ns = now_ns
        jumped = not 0 <= since_ns <= self._settings.jump_ns
        if jumped:
            # What was stamped by the clock before means nothing to them now.
            self._steering, self._footprint = (
                SteeringMonitor(self._settings),
                FootprintMonitor(self._settings),
            )
        asked = self._asked
        if asked is None:
            return ()
        if asked.enable and self.cause is None:
            self.cause = "clock_jumped" if jumped else self._danger(asked, now_ns)
            self._refused_then = self.refused
        frames, self._pending = self._pending, ()
        if self.cause is not None:
            return self._brake(now_ns)
        if frames:
            self._steering.sent(now_ns, asked)
        return frames

    def word(self, now_ns: int) -> tuple[CanFrame, ...]:
        """For the tick, after each step: that the gate brakes, and once that it does no longer."""
        self._tells = 2 if self.cause is not None else max(0, self._tells - 1)
        return (gate_report(self.cause, now_ns),) if self._tells else ()

    @property
    def braking(self) -> str:
        """For people."""
        if self.cause is None:
            return ""
        return self._refused_then if self.cause == "commands_refused" else _SAYS[self.cause]

    def _danger(self, asked: CommandedActuation, now_ns: int) -> GateCause | None:
        """Why the gate must brake now, None when all is well. Without by-wire there is nothing to brake."""
        if not self._pending and now_ns - self._last_ns > self._settings.fresh_ns:
            return "commands_refused" if self.refused else "tick_late"
        motion = self._motion
        if motion is None or not motion.stamp_ns:
            return None
        if now_ns - motion.stamp_ns > self._settings.reports_ns:
            return "module_lost"
        if self._footprint.is_close(motion, asked, now_ns):
            return "footprint"
        if self._speed.is_over(motion):
            return "too_fast"
        return "steering_stuck" if self._steering.is_stuck(motion) else None

    def _brake(self, now_ns: int) -> tuple[CanFrame, ...]:
        """Comfortably first, then fully, and held; the steering as it was, by-wire kept alive."""
        self._braked_steps += 1
        gently = self.cause != "footprint" and self._braked_steps <= self._settings.comfort_steps
        ratio = self._settings.comfort_ratio if gently else 1.0
        return self._by_wire.braking_frames(self._last, self._braked_steps, now_ns, ratio)

    def _lets_go(self, asked: CommandedActuation) -> bool:
        """The vehicle stands, or is not by-wire's, and the tick's enable falls and rises again."""
        motion = self._motion
        stands = motion is not None and (
            abs(motion.speed_mps) < self._settings.standing_mps or not motion.enabled
        )
        if not asked.enable:
            self._saw_disabled = stands
            return False
        if not (self._saw_disabled and stands):
            return False
        self._saw_disabled = False
        return True


def gate_of(profile: Profile) -> Gate:
    """The gate of a kind of vehicle."""
    return Gate(braking_of(profile), motion_reports_of(profile), gate_settings(profile))
