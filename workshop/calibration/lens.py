"""The lens of a camera from pictures of a chessboard, by OpenCV's calibration (Zhang 2000)."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vehicle_agent.perception.camera.lens import Lens
from vehicle_agent.perception.camera.people_detector import opencv

PICTURES_MIN = 8
# A picture whose corners lie farther off than so is blurred, or its board bent.
_RMS_PX_MAX = 1.0
# What the corners must reach of the picture's width and height: elsewhere the distortion is a guess.
_REACH_MIN = 0.6


class LensPicturesError(Exception):
    """Pictures from which no lens is found; the message says what to do."""


@dataclass(frozen=True, slots=True)
class LensFound:
    """lens, and by picture: px of the corners' deviation; None for one without a whole board."""

    lens: Lens
    rms_px: dict[str, float | None]
    reach: tuple[float, float]


def lens_of(pictures: list[Path], columns: int, rows: int, square_m: float) -> LensFound:
    """columns, rows: inner corners of the board. Raises LensPicturesError, CameraLibraryMissing."""
    cv2 = opencv()
    board = np.zeros((rows * columns, 3), dtype=np.float32)
    across, down = np.meshgrid(np.arange(columns), np.arange(rows))
    board[:, 0], board[:, 1] = square_m * across.ravel(), square_m * down.ravel()
    found: dict[str, np.ndarray | None] = {}
    size: tuple[int, int] | None = None
    for path in pictures:
        picture = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        if picture is None:
            raise LensPicturesError(f"{path} is no picture")
        here = (picture.shape[1], picture.shape[0])
        if size is not None and here != size:
            raise LensPicturesError(f"{path} has {here[0]} x {here[1]} px, others {size[0]} x {size[1]}")
        size = here
        is_there, corners = cv2.findChessboardCornersSB(
            picture, (columns, rows), flags=cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_EXHAUSTIVE
        )
        found[path.name] = corners.reshape(-1, 2) if is_there else None
    seen = {name: corners for name, corners in found.items() if corners is not None}
    if size is None or len(seen) < PICTURES_MIN:
        raise LensPicturesError(
            f"the board of {columns} x {rows} inner corners is whole in {len(seen)} of {len(pictures)} "
            f"pictures; {PICTURES_MIN} are needed, from different sides"
        )
    try:
        rms_px, K, distortion, _, _, _, _, by_picture = cv2.calibrateCameraExtended(
            [board] * len(seen), list(seen.values()), size, None, None
        )
    except cv2.error as error:
        raise LensPicturesError("no lens fits these pictures; hold the board from different sides") from error
    if rms_px > _RMS_PX_MAX:
        raise LensPicturesError(
            f"corners lie {rms_px:.2f} px off; sharper pictures of a flat board are needed "
            f"(at most {_RMS_PX_MAX:g} px)"
        )
    corners = np.concatenate(list(seen.values()))
    reach = np.ptp(corners, axis=0) / size
    if reach.min() < _REACH_MIN:
        raise LensPicturesError(
            f"the board was seen in {100 * reach[0]:.0f} % of the width and {100 * reach[1]:.0f} % of the "
            f"height; hold it into all corners too ({100 * _REACH_MIN:.0f} % are needed)"
        )
    try:
        lens = Lens(
            width_px=size[0],
            height_px=size[1],
            fx_px=round(float(K[0, 0]), 3),
            fy_px=round(float(K[1, 1]), 3),
            cx_px=round(float(K[0, 2]), 3),
            cy_px=round(float(K[1, 2]), 3),
            distortion=tuple(round(float(value), 6) for value in np.ravel(distortion)[:5]),
            rms_px=round(float(rms_px), 3),
        )
    except ValueError as error:
        raise LensPicturesError(f"the lens that fits best is none: {error}; take other pictures") from error
    left = dict(zip(seen, np.ravel(by_picture).tolist(), strict=True))
    return LensFound(lens, {name: left.get(name) for name in found}, (float(reach[0]), float(reach[1])))
