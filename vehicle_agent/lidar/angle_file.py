"""A sensor's own beam angles: Hesai's correction files (`Laser id,Elevation,Azimuth`, degrees)."""

import csv
import io
import math

import numpy as np

from vehicle_agent.lidar.models import LidarModel

# A beam that is farther from its nominal place belongs to another model.
_APART_DEG_MAX = 3.0


class AngleFileError(ValueError):
    """A file of angles that does not fit; the message says why."""


def with_angle_file(model: LidarModel, text: str) -> LidarModel:
    """`model` with the angles of the file's lines, which name channels from 1 on, in any order.

    Raises AngleFileError: lines that are no numbers, a channel that is missing or named twice, or angles that
    are not this model's.
    """
    rows = [row for row in csv.reader(io.StringIO(text.lstrip("\ufeff"))) if row and row[0].strip().isdigit()]
    angles_deg = np.full((model.channels, 2), np.nan)
    for row in rows:
        channel = int(row[0])
        if not 1 <= channel <= model.channels:
            raise AngleFileError(f"channel {channel}: a {model.name} has {model.channels}")
        if not np.isnan(angles_deg[channel - 1, 0]):
            raise AngleFileError(f"channel {channel} is there twice")
        try:
            elevation_deg, azimuth_deg = float(row[1]), float(row[2])
        except (ValueError, IndexError) as error:
            raise AngleFileError(f"channel {channel}: elevation and azimuth in degrees are due") from error
        if not (math.isfinite(elevation_deg) and math.isfinite(azimuth_deg)):
            raise AngleFileError(f"channel {channel}: an angle is not finite")
        angles_deg[channel - 1] = elevation_deg, azimuth_deg
    missing = np.flatnonzero(np.isnan(angles_deg[:, 0])) + 1
    if len(missing):
        raise AngleFileError(f"channels without angles: {', '.join(map(str, missing))}")
    apart_deg = np.abs(angles_deg[:, 0] - np.degrees(model.elevations_rad))
    if apart_deg.max() > _APART_DEG_MAX:
        channel = int(apart_deg.argmax()) + 1
        raise AngleFileError(
            f"channel {channel} looks {angles_deg[channel - 1, 0]:.2f} degrees up; "
            f"a {model.name}'s looks {math.degrees(model.elevations_rad[channel - 1]):.2f}"
        )
    return model.with_angles(np.radians(angles_deg[:, 0]), np.radians(angles_deg[:, 1]))
