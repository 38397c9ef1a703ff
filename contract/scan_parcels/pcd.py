"""The scans of a parcel: PCD 0.7, binary, float32 x y z. Other PCD files are read by `workshop/clouds`."""

import re

import numpy as np

# To this step positions are rounded: lidars err by more, and equal digits compress.
_STEP_M = 1.0 / 512.0
_HEADER = (
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n"
    "COUNT 1 1 1\nWIDTH {n}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA binary\n"
)
_POINTS = re.compile(rb"\nPOINTS (\d{1,9})\nDATA binary\n")


class PcdError(ValueError):
    """The bytes are no scan of a parcel; the message is one sentence."""


def encoded_points(points_base: np.ndarray) -> bytes:
    """The file of points (n, 3), metres."""
    rounded = np.rint(np.asarray(points_base, dtype=np.float64) / _STEP_M) * _STEP_M
    return _HEADER.format(n=len(rounded)).encode() + rounded.astype("<f4").tobytes()


def points_in(data: bytes) -> np.ndarray:
    """(n, 3) float32 of such a file. Raises PcdError."""
    found = _POINTS.search(data[:400])
    if found is None or data[: found.end()] != _HEADER.format(n=int(found[1])).encode():
        raise PcdError("the file is no PCD as vehicles write it.")
    count = int(found[1])
    if not count:
        raise PcdError("the scan has no point.")
    if len(data) - found.end() != 12 * count:
        raise PcdError(f"the file ends before its {count} points do, or after.")
    points = np.frombuffer(data, "<f4", 3 * count, found.end()).reshape(count, 3)
    if not np.isfinite(points).all():
        raise PcdError("a point is not finite.")
    return points
