"""Why lidars cannot be calibrated with these scans."""

from typing import Literal

CalibrationCode = Literal[
    "too_few_lidars",
    "too_few_points",
    "too_few_planes",
    "no_match",
    "ambiguous",
    "degenerate",
    "bad_extrinsics",
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
    """

    def __init__(self, code: CalibrationCode, detail: str) -> None:
        super().__init__(detail)
        self.code = code
