"""can, localization: the vehicle's own motion and pose, and their faults."""

from typing import Literal

import msgspec

from contract.geometry import Pose2
from contract.wire.messages import FaultReport, Headlights, TurnSignal
from contract.wire.reasons import FaultCode, FaultSeverity, LocalizationPhase


class Fault(msgspec.Struct, frozen=True):
    """A fault; one of severity `stop` ends in a minimal-risk stop."""

    code: FaultCode
    severity: FaultSeverity
    since_ns: int


ReportedGear = Literal["park", "reverse", "neutral", "drive", "low"]

# The fault of the gate's own braking; the gate releases the brake only after a new by-wire request.
GATE_BRAKING = "gate_braking"


class VehicleMotion(msgspec.Struct, frozen=True):
    """can: the drive-by-wire reports, in SI units.

    stamp_ns      arrival of the newest speed report (0 before the first)
    steer_rad     front-wheel angle of the bicycle model, left positive
    enabled       by-wire controls the vehicle
    overridden    the safety driver has taken over since the last enable
    wheels_radps  turning rates: front left, front right, rear left, rear right

    The values with the default None are None where the vehicle does not report them.
    """

    stamp_ns: int
    speed_mps: float
    steer_rad: float
    throttle_ratio: float
    brake_ratio: float
    enabled: bool
    overridden: bool
    ready: bool
    battery_ratio: float
    faults: tuple[Fault, ...] = ()
    yaw_rate_radps: float | None = None
    wheels_radps: tuple[float, float, float, float] | None = None
    gear: ReportedGear | None = None
    turn_signal: TurnSignal | None = None
    horn: bool | None = None
    headlights: Headlights | None = None


class Ego(msgspec.Struct, frozen=True):
    """localization: the vehicle's pose and motion at `stamp_ns` (this tick).

    valid is False before the first fix, and when the solution is too old or too poor; `faults` has
    the reason.

    position_std_m  standard deviation of the position along its worst direction
    phase, agreement  of localization by scans; None where none are compared with a map
    proven_ns       when the place of a vehicle that had been lost was proven; 0 never
    pose_stamp_ns   when the pose was last good enough to drive by, with or without a fix; 0 never
    """

    stamp_ns: int
    pose_map: Pose2
    speed_mps: float
    accel_mps2: float
    yaw_rate_radps: float
    steer_rad: float
    position_std_m: float
    pose_stamp_ns: int
    valid: bool
    faults: tuple[Fault, ...] = ()
    phase: LocalizationPhase | None = None
    agreement: float | None = None
    proven_ns: int = 0


def fault_report(fault: Fault) -> FaultReport:
    """A fault as the server reads it."""
    return FaultReport(fault.code, fault.severity, fault.since_ns)
