"""Why sensors cannot be calibrated with these recordings."""

from typing import Literal

CalibrationCode = Literal[
    "too_few_lidars",
    "too_few_points",
    "too_few_planes",
    "no_match",
    "ambiguous",
    "degenerate",
    "bad_extrinsics",
    "too_few_scans",
    "too_few_samples",
    "bad_samples",
    "no_common_time",
    "no_motion",
    "no_turns",
]


class CalibrationError(Exception):
    """A calibration that is refused.

    too_few_lidars   fewer than two
    too_few_points   of a lidar, for any plane
    too_few_planes   of a lidar, and no guess of its pose is given
    no_match         no pose was found at which the scans fit
    ambiguous        two poses fit alike
    degenerate       what the lidars see in common leaves a direction open, as a street without ends does
    bad_extrinsics   the file of given poses cannot be read

    By motion also:
    ambiguous        the clocks fit at two offsets alike
    degenerate       the drive leaves the rotation or the clocks' offset open
    too_few_scans    of a drive, or between its gaps
    too_few_samples  of the inertial unit; bad_samples: they are not finite, or not in m/s2 with gravity
    no_common_time   scans and samples have little time in common, or do not turn at the same moments
    no_motion        the vehicle stands
    no_turns         it goes straight
    """

    def __init__(self, code: CalibrationCode, detail: str) -> None:
        super().__init__(detail)
        self.code = code
