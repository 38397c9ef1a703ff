"""The safety driver's input to the pedals, the steering wheel and the stalks."""

from dataclasses import dataclass

from vehicle_agent.signals import Headlights, TurnSignal

OVERRIDE_PEDAL_RATIO = 0.05


@dataclass(frozen=True, slots=True)
class SafetyDriver:
    """steer_rad None: hands off the wheel."""

    brake_ratio: float = 0.0
    throttle_ratio: float = 0.0
    steer_rad: float | None = None
    turn_signal: TurnSignal = "none"
    horn: bool = False
    headlights: Headlights = "off"

    @property
    def takes_over(self) -> bool:
        return (
            self.brake_ratio > OVERRIDE_PEDAL_RATIO
            or self.throttle_ratio > OVERRIDE_PEDAL_RATIO
            or self.steer_rad is not None
        )


HANDS_OFF = SafetyDriver()
