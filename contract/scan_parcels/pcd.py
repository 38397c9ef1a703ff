"""The scans of a parcel: PCD 0.7, binary, float32 x y z, and t for a lidar that turns while it measures.

Other PCD files are read by `workshop/clouds`.
"""

import re

import numpy as np

# To this step positions are rounded: lidars err by more, and equal digits compress.
_STEP_M = 1.0 / 512.0
_HEADER = (
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {fields}\nSIZE {sizes}\nTYPE {types}\n"
    "COUNT {counts}\nWIDTH {n}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA binary\n"
)
_POINTS = re.compile(rb"\nPOINTS (\d{1,9})\nDATA binary\n")


class PcdError(ValueError):
    """The bytes are no scan of a parcel; the message is one sentence."""


def encoded_points(points_base: np.ndarray, offsets_s: np.ndarray | None = None) -> bytes:
    """The file of points (n, 3), metres, each offsets_s (n,) after the first one; None: all at once."""
    rounded = np.rint(np.asarray(points_base, dtype=np.float64) / _STEP_M) * _STEP_M
    columns = [rounded] if offsets_s is None else [rounded, np.asarray(offsets_s).reshape(-1, 1)]
    table = np.hstack(columns).astype("<f4")
    return _header(len(table), table.shape[1]) + table.tobytes()


def points_in(data: bytes) -> np.ndarray:
    """(n, 3) float32 of such a file, or (n, 4) with the times. Raises PcdError."""
    found = _POINTS.search(data[:400])
    count = 0 if found is None else int(found[1])
    heads = {width: _header(count, width) for width in (3, 4)}
    width = next((width for width, head in heads.items() if data.startswith(head)), 0)
    if found is None or not width:
        raise PcdError("the file is no PCD as vehicles write it.")
    if not count:
        raise PcdError("the scan has no point.")
    if len(data) - found.end() != 4 * width * count:
        raise PcdError(f"the file ends before its {count} points do, or after.")
    points = np.frombuffer(data, "<f4", width * count, found.end()).reshape(count, width)
    if not np.isfinite(points).all():
        raise PcdError("a value is not finite.")
    return points


def _header(count: int, width: int) -> bytes:
    names = ("x", "y", "z", "t")[:width]
    columns = {"sizes": "4", "types": "F", "counts": "1"}
    rows = {row: " ".join([value] * width) for row, value in columns.items()}
    return _HEADER.format(n=count, fields=" ".join(names), **rows).encode()
