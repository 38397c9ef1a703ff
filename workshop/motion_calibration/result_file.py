"""What was found, as TOML."""

from collections.abc import Iterable

import numpy as np

from contract.transforms import angles_of
from workshop.motion_calibration.calibrate import MotionCalibration


def inertial_toml(found: MotionCalibration) -> str:
    """Metres, degrees, seconds; standard deviations about and along the lidar's axes."""
    unknowns = found.adjustment.unknowns
    x, y, z = found.T_lidar_unit[:3, 3]
    roll, pitch, yaw = np.degrees(angles_of(found.T_lidar_unit))
    kept = ", ".join(f"[{_joined(direction, 4)}]" for direction in found.kept)
    return "\n".join(
        [
            "# T_lidar_unit: points of the inertial unit in the lidar's frame. Roll, pitch, yaw about the",
            "# fixed axes x, y, z, in this order. std: about and along the lidar's axes. kept: directions of",
            "# the lever arm, lidar frame, that the drive does not tell: along them it has the given value.",
            "[inertial]",
            f"x_m = {x:.5f}\ny_m = {y:.5f}\nz_m = {z:.5f}",
            f"roll_deg = {roll:.4f}\npitch_deg = {pitch:.4f}\nyaw_deg = {yaw:.4f}",
            f"std_m = [{_joined(found.lever_std_m, 5)}]",
            f"std_deg = [{_joined(np.degrees(found.rotation_std_rad), 4)}]",
            f"kept = [{kept}]",
            "# Has to be added to the unit's stamps to be the lidar's time.",
            f"clock_offset_s = {found.offset_s:.5f}",
            f"clock_offset_std_s = {found.offset_std_s:.5f}",
            f"rate_bias_radps = [{_joined(unknowns.rate_bias_radps, 6)}]",
            f"force_bias_mps2 = [{_joined(unknowns.force_bias_mps2, 4)}]",
            "",
        ]
    )


def _joined(values: Iterable[float], digits: int) -> str:
    return ", ".join(f"{value:.{digits}f}" for value in values)
