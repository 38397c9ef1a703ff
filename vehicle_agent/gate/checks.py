"""Which command sets the gate accepts: complete, fresh, in order, and within the vehicle's limits."""

from vehicle_agent.can.braking import ByWireBraking, CommandedActuation, CommandSetError
from vehicle_agent.gate.settings import GateSettings
from vehicle_agent.signals import CanFrame


class CommandChecks:
    """Checks each set against the limits and against the last set that was accepted."""

    def __init__(self, by_wire: ByWireBraking, settings: GateSettings) -> None:
        self._by_wire = by_wire
        self._settings = settings
        self._last: CommandedActuation | None = None
        self._last_ns = 0

    def accepted(self, frames: tuple[CanFrame, ...], now_ns: int) -> CommandedActuation:
        """The actuation that a set commands. Raises CommandSetError with the reason for a refusal."""
        commanded = self._by_wire.commanded(frames)
        self._check_time(frames[0].stamp_ns, now_ns)
        if self._last is not None:
            self._check_order(commanded, self._last, now_ns)
        self._check_limits(commanded, now_ns)
        self._last, self._last_ns = commanded, now_ns
        return commanded

    def _check_time(self, stamp_ns: int, now_ns: int) -> None:
        if now_ns - stamp_ns > self._settings.late_ns:
            raise CommandSetError("the set is stale")
        if stamp_ns - now_ns > self._settings.early_ns:
            raise CommandSetError("the set is stamped in the future")

    def _check_order(self, commanded: CommandedActuation, last: CommandedActuation, now_ns: int) -> None:
        steps = (commanded.counter - last.counter) % self._by_wire.counter_steps
        if steps == 0:
            raise CommandSetError("the counter stands still")
        if now_ns - self._last_ns <= self._settings.fresh_ns and steps > self._settings.sets_lost_max + 1:
            raise CommandSetError("the set is out of order")

    def _check_limits(self, commanded: CommandedActuation, now_ns: int) -> None:
        settings = self._settings
        if abs(commanded.steer_rad) > settings.steer_rad_max + settings.angle_slack_rad:
            raise CommandSetError("the steering angle is beyond its limit")
        last = self._last
        if last is None or not (last.enable and commanded.enable):
            return
        # The guard limits the rate over at most 0.1 s; a tick's own jitter is in the slack.
        dt_s = max(0.02, (now_ns - self._last_ns) * 1e-9)
        reach = settings.rate_slack * settings.steer_rate_radps_max * dt_s + settings.angle_slack_rad
        if abs(commanded.steer_rad - last.steer_rad) > reach:
            raise CommandSetError("the steering angle jumps")
