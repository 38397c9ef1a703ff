"""can, localization: the vehicle itself, and what is wrong with it."""

from typing import Literal

import msgspec

from contract.geometry import Pose2
from contract.wire.messages import FaultReport


class Fault(msgspec.Struct, frozen=True):
    """Something is not as it should be. `stop` faults end in a minimal-risk stop."""

    code: str
    severity: Literal["info", "warning", "stop"]
    since_ns: int


# The fault that stands for the gate's own braking: it lets go only when by-wire is asked for anew.
GATE_BRAKING = "gate_braking"


class VehicleMotion(msgspec.Struct, frozen=True):
    """can: what the drive-by-wire reports, in SI units.

    stamp_ns      arrival of the newest speed report (0 before the first)
    steer_rad     front-wheel angle of the bicycle model, left positive
    enabled       by-wire has the vehicle
    overridden    the safety driver has taken over since the last enable
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


class Ego(msgspec.Struct, frozen=True):
    """localization: the vehicle itself, at `stamp_ns` (this tick).

    valid is False until the first fix and when the solution is too old or too poor to drive by; `faults`
    says what is wrong with it.
    """

    stamp_ns: int
    pose_map: Pose2
    speed_mps: float
    accel_mps2: float
    yaw_rate_radps: float
    steer_rad: float
    position_std_m: float
    fix_stamp_ns: int
    valid: bool
    faults: tuple[Fault, ...] = ()


def fault_report(fault: Fault) -> FaultReport:
    """A fault as the server reads it."""
    return FaultReport(fault.code, fault.severity, fault.since_ns)
