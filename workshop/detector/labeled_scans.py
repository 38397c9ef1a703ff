"""Scans with the boxes of what they show, as the detector is trained and measured on them."""

import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array

Array32 = NDArray[np.float32]
# Stored coordinates are multiples of this; the sensors' noise is greater.
_GRAIN_M = 0.002
BOX_COLUMNS = 8


class LabeledScan(NamedTuple):
    """One scan of two turns.

    points   (n, 4) float32 x, y in the base frame at the newer turn's end, height above the ground, intensity
    is_older (n,) bool: of the older turn, which was moved by the vehicle's own motion since
    older_s  how much older it is
    kinds    (m,) int64 index into TRACK_KINDS
    boxes    (m, 8) x, y, yaw, length, width, height (m, rad), velocity x, y over ground along the base's axes
    hits     (m,) int64 returns of the newer turn in each box
    """

    points: Array32
    is_older: NDArray[np.bool_]
    older_s: float
    kinds: NDArray[np.int64]
    boxes: Array
    hits: NDArray[np.int64]


class ScanFileError(Exception):
    """The file holds no labeled scan."""


def write_scan(path: Path, scan: LabeledScan) -> None:
    """Points are rounded to 2 mm and whole intensities."""
    grains = np.rint(scan.points[:, :3] / _GRAIN_M).clip(-32_768, 32_767).astype(np.int16)
    intensities = scan.points[:, 3].clip(0, 255).astype(np.uint8)
    with path.open("wb") as file:
        np.savez(
            file, grains=grains, intensities=intensities, is_older=np.packbits(scan.is_older),
            older_s=scan.older_s, kinds=scan.kinds, boxes=scan.boxes, hits=scan.hits,
        )  # fmt: skip


def read_scan(path: Path) -> LabeledScan:
    """Raises ScanFileError for another file, and OSError."""
    try:
        with np.load(path) as arrays:
            grains, n = arrays["grains"], len(arrays["grains"])
            points = np.empty((n, 4), dtype=np.float32)
            points[:, :3] = grains * np.float32(_GRAIN_M)
            points[:, 3] = arrays["intensities"]
            older = np.unpackbits(arrays["is_older"], count=n).astype(bool)
            return LabeledScan(
                points, older, float(arrays["older_s"]), arrays["kinds"], arrays["boxes"], arrays["hits"]
            )
    except (KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise ScanFileError(f"{path} is no labeled scan") from error
