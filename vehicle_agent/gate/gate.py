"""The second layer of safety: between the tick and the CAN bus, and the only owner of the bus.

The gate knows nothing of roads or plans. Fresh, consistent commands within the limits pass. The gate starts
its own brake sequence when the tick or the module is silent, when the clock jumps, when the steering does not
follow, when the speed is excessive, or when the tick does not brake for an obstacle ahead of the bumper. The
sequence ends when the vehicle stands and the tick requests by-wire again in two frames, which takes an
operator's resume.
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

_TEXTS: dict[GateCause, str] = {
    "tick_late": "the tick is silent",
    "module_lost": "the module is silent",
    "clock_jumped": "the clock jumped",
    "footprint": "something before the bumper",
    "too_fast": "too fast",
    "steering_stuck": "the steering does not follow",
}


class Gate:
    """Checks and forwards command frames, or brakes.

    refused  why the last command set was not forwarded, empty when it was
    cause    why the gate itself brakes, None when it does not; braking: the same as text
    """

    def __init__(self, by_wire: ByWireBraking, reports: MotionReports, settings: GateSettings) -> None:
        self._by_wire, self._settings = by_wire, settings
        self._reports = reports
        self._motion: VehicleMotion | None = None
        self._checks = CommandChecks(by_wire, settings)
        self._steering, self._speed = SteeringMonitor(settings), SpeedMonitor(settings)
        self._footprint = FootprintMonitor(settings)
        self.refused, self._refused_at_brake = "", ""
        self.cause: GateCause | None = None
        self._pending: tuple[CanFrame, ...] = ()
        self._last: tuple[CanFrame, ...] = ()
        self._commanded: CommandedActuation | None = None
        self._last_ns = 0
        self._stepped_ns = 0
        self._braked_steps = 0
        self._saw_disabled = False
        self._reports_left = 0

    def take_reports(self, frames: tuple[CanFrame, ...], now_ns: int) -> None:
        """Takes the module's reports, before they go on to the tick."""
        self._motion = self._reports.decode(frames, now_ns)

    def take_percept(self, percept: Percept) -> None:
        """Takes a percept straight from the perception worker."""
        self._footprint.take_percept(percept)

    def take_commands(self, frames: tuple[CanFrame, ...], now_ns: int) -> None:
        """Takes one tick's command frames.

        A set that is inconsistent, old, repeated or beyond the limits is refused: a stale command must not
        look fresh to the module.
        """
        try:
            commanded = self._checks.accepted(frames, now_ns)
        except CommandSetError as error:
            self.refused = str(error)
            return
        self.refused = ""
        if self.cause is not None and not self._is_released_by(commanded):
            return
        self.cause = None
        self._last, self._pending, self._commanded = frames, frames, commanded
        self._last_ns = now_ns
        self._braked_steps = 0

    def step(self, now_ns: int) -> tuple[CanFrame, ...]:
        """Frames for the bus, every 20 ms: the tick's, none before the first set, or the gate's brake."""
        since_ns = now_ns - self._stepped_ns if self._stepped_ns else 0
        self._stepped_ns = now_ns
        jumped = not 0 <= since_ns <= self._settings.jump_ns
        if jumped:
            # Stamps of the earlier clock mean nothing to the monitors.
            self._steering, self._footprint = (
                SteeringMonitor(self._settings),
                FootprintMonitor(self._settings),
            )
        commanded = self._commanded
        if commanded is None:
            return ()
        if commanded.enable and self.cause is None:
            self.cause = "clock_jumped" if jumped else self._brake_cause(commanded, now_ns)
            self._refused_at_brake = self.refused
        frames, self._pending = self._pending, ()
        if self.cause is not None:
            return self._brake(now_ns)
        if frames:
            self._steering.record_sent(now_ns, commanded)
        return frames

    def report_frames(self, now_ns: int) -> tuple[CanFrame, ...]:
        """Reports to the tick, after each step: that the gate brakes, and once that it has released."""
        self._reports_left = 2 if self.cause is not None else max(0, self._reports_left - 1)
        return (gate_report(self.cause, now_ns),) if self._reports_left else ()

    @property
    def braking(self) -> str:
        """Why the gate brakes, as text for people; empty when it does not."""
        if self.cause is None:
            return ""
        return self._refused_at_brake if self.cause == "commands_refused" else _TEXTS[self.cause]

    def _brake_cause(self, commanded: CommandedActuation, now_ns: int) -> GateCause | None:
        """Why the gate must brake now, None when it need not."""
        if not self._pending and now_ns - self._last_ns > self._settings.fresh_ns:
            return "commands_refused" if self.refused else "tick_late"
        motion = self._motion
        if motion is None or not motion.stamp_ns:
            return None
        if now_ns - motion.stamp_ns > self._settings.reports_ns:
            return "module_lost"
        if self._footprint.is_close(motion, commanded, now_ns):
            return "footprint"
        if self._speed.is_over(motion):
            return "too_fast"
        return "steering_stuck" if self._steering.is_stuck(motion) else None

    def _brake(self, now_ns: int) -> tuple[CanFrame, ...]:
        """The brake sequence: comfortable, then full, then held; steering and enable stay as they were."""
        self._braked_steps += 1
        gently = self.cause != "footprint" and self._braked_steps <= self._settings.comfort_steps
        ratio = self._settings.comfort_ratio if gently else 1.0
        return self._by_wire.braking_frames(self._last, self._braked_steps, now_ns, ratio)

    def _is_released_by(self, commanded: CommandedActuation) -> bool:
        """The vehicle stands or by-wire is off, and the tick's enable has fallen and risen again."""
        motion = self._motion
        stands = motion is not None and (
            abs(motion.speed_mps) < self._settings.standing_mps or not motion.enabled
        )
        if not commanded.enable:
            self._saw_disabled = stands
            return False
        if not (self._saw_disabled and stands):
            return False
        self._saw_disabled = False
        return True


def gate_of(profile: Profile) -> Gate:
    """The gate of a vehicle profile."""
    return Gate(braking_of(profile), motion_reports_of(profile), gate_settings(profile))
