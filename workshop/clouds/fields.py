"""Named columns of points, as PCD, PLY and PointCloud2 have them, to one point cloud.

The names are those of the ROS drivers of Velodyne, Hesai, Ouster, Livox and Robosense.
"""

from collections.abc import Mapping

import numpy as np

from contract.geometry import Array
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud

_INTENSITY = ("intensity", "i", "reflectivity", "scalar_intensity", "scalar_Intensity")
_RING = ("ring", "channel", "line", "laser_id", "scalar_ring")
_TIME = ("timestamp", "time_stamp", "time", "t", "offset_time", "point_time_offset", "timeSecond", "GPSTime")
# A scan takes 4 ms to 2 s: of seconds, milliseconds, microseconds and nanoseconds one unit alone fits.
_UNITS_S = (1.0, 1e-3, 1e-6, 1e-9)
_SPREAD_S = (0.004, 2.0)
# Numbers above this are dates, whatever their unit: offsets within a scan stay below two seconds.
_DATE_S = 1e8


class MissingFieldError(Exception):
    """A cloud without x, y or z."""


def cloud_of_fields(fields: Mapping[str, np.ndarray], stamp_ns: int | None) -> PointCloud:
    """The points of columns (n,) by name; points that are not finite are left out (drivers fill gaps by NaN).

    stamp_ns: of the file or message. None: the first point's time if that is a date, 0 otherwise.
    MissingFieldError without coordinates.
    """
    missing = [name for name in ("x", "y", "z") if name not in fields]
    if missing:
        raise MissingFieldError(f"no field {', '.join(missing)}; there are: {', '.join(fields) or 'none'}")
    points = np.column_stack([fields[name].astype(np.float32) for name in ("x", "y", "z")])
    finite = np.asarray(np.isfinite(points).all(axis=1))
    intensities, rings = _first(fields, _INTENSITY), _first(fields, _RING)
    offsets_ns, first_ns = _times(_first(fields, _TIME), finite)
    return point_cloud(
        (first_ns or 0) if stamp_ns is None else stamp_ns,
        points[finite],
        None if intensities is None else np.nan_to_num(intensities[finite].astype(np.float32)),
        None if rings is None else np.clip(np.nan_to_num(rings[finite]), 0, 65_535),
        offsets_ns,
    )


def _first(fields: Mapping[str, np.ndarray], names: tuple[str, ...]) -> np.ndarray | None:
    return next((fields[name] for name in names if name in fields), None)


def _times(times: np.ndarray | None, finite: np.ndarray) -> tuple[np.ndarray | None, int | None]:
    """(offsets (n,) ns of the finite points from the first of them, its date in ns if it has one)."""
    if times is None or not finite.any():
        return None, None
    times = times[finite]
    if times.dtype.kind == "f":
        times = np.where(np.isfinite(times), times, np.nanmin(times) if np.isfinite(times).any() else 0.0)
    first = times.min()
    since: Array = (times - first).astype(np.float64)
    spread = float(since.max())
    for unit_s in _UNITS_S:
        if _SPREAD_S[0] <= spread * unit_s <= _SPREAD_S[1]:
            date = float(first) * unit_s > _DATE_S
            first_ns = _exact_ns(first, unit_s) if date else None
            return np.rint(since * unit_s * 1e9).astype(np.int64), first_ns
    # One time for all points, or times that cannot be of one scan: the points have none.
    return None, None


def _exact_ns(first: np.generic, unit_s: float) -> int:
    """A date in ns; whole numbers keep every digit."""
    value = first.item()
    per_unit = round(unit_s * 1e9)
    return value * per_unit if isinstance(value, int) else round(value * per_unit)
