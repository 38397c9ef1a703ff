"""The signals of a drive that identification reads, and what it refuses of them."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from contract.geometry import Array, BoolArray

IdentificationCode = Literal[
    "too_short",
    "gap",
    "not_enabled",
    "stood_still",
    "never_braked",
    "never_accelerated",
    "never_turned",
    "no_pose",
    "outside_range",
]


class IdentificationError(Exception):
    """The drive does not show the vehicle's response; the message says what to drive or check."""

    def __init__(self, code: IdentificationCode, detail: str) -> None:
        super().__init__(detail)
        self.code = code


@dataclass(frozen=True, slots=True)
class DriveSignals:
    """One drive, times in seconds of the vehicle's clock.

    tick_s (n,)      times of the ticks, dt_s apart
    commands (n, 3)  front-wheel angle (rad), throttle, brake: sent at the tick, as by-wire takes them
    driving (n,)     by-wire is enabled, the gear is drive, and no brake but the commanded one acts
    yaw_rate_radps (n,), heading_rad (n,)  of the gyroscope and of localization; NaN without a valid pose
    report_s (m,)    times of the module's reports
    speed_mps (m,), steer_rad (m,)  what they said
    """

    tick_s: Array
    commands: Array
    driving: BoolArray
    yaw_rate_radps: Array
    heading_rad: Array
    report_s: Array
    speed_mps: Array
    steer_rad: Array


DT_S = 0.02
_DRIVE_S_MIN = 120.0
_GAP_S_MAX = 0.2
_GAPS_SHARE_MAX = 0.01
_MOVING_MPS = 0.3
_MOVING_S_MIN = 60.0
_PEDAL_RATIO_MIN = 0.02
_PEDAL_S_MIN = 8.0
_TURN_RAD = 0.05
_TURN_S_MIN = 10.0


def check_drive(drive: DriveSignals) -> None:
    """Raises IdentificationError for a drive that cannot show the response."""
    tick_s, driving = drive.tick_s, drive.driving
    if len(tick_s) < 2 or len(drive.report_s) < 2 or tick_s[-1] - tick_s[0] < _DRIVE_S_MIN:
        raise IdentificationError(
            "too_short", f"the drive is shorter than {_DRIVE_S_MIN:.0f} s; drive five minutes"
        )
    _check_gaps(tick_s, "ticks")
    _check_gaps(drive.report_s, "reports of the by-wire module")
    if DT_S * float(driving.sum()) < _MOVING_S_MIN:
        raise IdentificationError(
            "not_enabled",
            f"by-wire drove for less than {_MOVING_S_MIN:.0f} s; a drive by hand shows no dead times",
        )
    speed = np.interp(tick_s, drive.report_s, drive.speed_mps)
    moving = driving & (speed > _MOVING_MPS)
    if DT_S * float(moving.sum()) < _MOVING_S_MIN:
        raise IdentificationError("stood_still", f"the vehicle moved for less than {_MOVING_S_MIN:.0f} s")
    if DT_S * float((moving & (drive.commands[:, 2] > _PEDAL_RATIO_MIN)).sum()) < _PEDAL_S_MIN:
        raise IdentificationError(
            "never_braked", f"it braked for less than {_PEDAL_S_MIN:.0f} s while it moved"
        )
    if DT_S * float((moving & (drive.commands[:, 1] > _PEDAL_RATIO_MIN)).sum()) < _PEDAL_S_MIN:
        raise IdentificationError(
            "never_accelerated", f"it accelerated for less than {_PEDAL_S_MIN:.0f} s while it moved"
        )
    steer = np.interp(tick_s, drive.report_s, drive.steer_rad)
    for side, name in ((1.0, "left"), (-1.0, "right")):
        if DT_S * float((moving & (side * steer > _TURN_RAD)).sum()) < _TURN_S_MIN:
            raise IdentificationError(
                "never_turned", f"it turned {name} for less than {_TURN_S_MIN:.0f} s; drive curves both ways"
            )
    if float(np.isfinite(drive.heading_rad[moving]).mean()) < 0.9:
        raise IdentificationError("no_pose", "the vehicle was not localized for a tenth of the drive")


def _check_gaps(times_s: Array, what: str) -> None:
    """Drives may have a few gaps, which the fits leave out; not many."""
    steps_s = np.diff(times_s)
    if not np.all(steps_s > 0.0):
        raise IdentificationError("gap", f"the times of the {what} do not rise")
    lost_s = float(steps_s[steps_s > _GAP_S_MAX].sum())
    if lost_s > _GAPS_SHARE_MAX * float(times_s[-1] - times_s[0]):
        raise IdentificationError("gap", f"{lost_s:.1f} s of the {what} are missing")
