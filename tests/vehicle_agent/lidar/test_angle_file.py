"""A Hesai's own angles replace the nominal ones; a file that does not belong to it is refused."""

import numpy as np
import pytest

from vehicle_agent.lidar.angle_file import AngleFileError, with_angle_file
from vehicle_agent.lidar.models import XT16


def lines(channels: int = 16, shift_deg: float = 0.0) -> list[str]:
    return [f"{n + 1},{15.0 - 2.0 * n + shift_deg:.3f},{0.01 * n:.3f}" for n in range(channels)]


def text(rows: list[str]) -> str:
    return "\r\n".join(["Laser id,Elevation,Azimuth", *rows]) + "\r\n"


def test_the_files_angles_are_taken_whatever_the_order_of_its_lines() -> None:
    model = with_angle_file(XT16, "\ufeff" + text(lines(shift_deg=0.08)[::-1]))
    assert model.name == "XT16"
    assert np.degrees(model.elevations_rad) == pytest.approx(15.08 - 2.0 * np.arange(16))
    assert np.degrees(model.azimuths_rad) == pytest.approx(0.01 * np.arange(16))


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (lines(15), "channels without angles: 16"),
        (lines(17), "channel 17: a XT16 has 16"),
        ([*lines(), "3,11.0,0.0"], "channel 3 is there twice"),
        ([*lines(15), "16,down,0.0"], "channel 16: elevation and azimuth"),
        ([*lines(15), "16,-15.0"], "channel 16: elevation and azimuth"),
        ([*lines(15), "16,nan,0.0"], "channel 16: an angle is not finite"),
        (lines(shift_deg=5.0), "looks 20.00 degrees up"),
        ([], "channels without angles"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(rows: list[str], says: str) -> None:
    with pytest.raises(AngleFileError, match=says):
        with_angle_file(XT16, text(rows))
