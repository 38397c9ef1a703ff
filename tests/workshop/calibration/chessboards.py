"""Pictures of a chessboard as a camera with a known lens sees them."""

from pathlib import Path

import numpy as np
import pytest

from vehicle_agent.perception.camera.lens import Lens

COLUMNS, ROWS, SQUARE_M = 9, 6, 0.025
# A webcam of 65 degrees whose straight lines bend visibly.
LENS = Lens(640, 480, 512.0, 510.0, 324.0, 236.0, (-0.28, 0.09, 0.0007, -0.0004, 0.0))


def write_pictures(folder: Path, count: int, seed: int = 1, spread: float = 1.0) -> None:
    """count pictures of the board from different sides; spread: how far from the middle it is held."""
    cv2 = pytest.importorskip("cv2", reason="needs the extra `camera`")
    rng = np.random.default_rng(seed)
    rays = _rays()
    for number in range(count):
        side = (number % 3 - 1, number // 3 % 3 - 1)
        picture = _board(cv2, rays, rng, (spread * 0.075 * side[0], spread * 0.055 * side[1]))
        cv2.imwrite(str(folder / f"{number:02}.png"), picture)


def _rays() -> np.ndarray:
    """(n, 3) through the middle of each pixel: the lens's formula, turned round by iteration."""
    v, u = np.indices((LENS.height_px, LENS.width_px), dtype=np.float64).reshape(2, -1)
    seen_x, seen_y = (u - LENS.cx_px) / LENS.fx_px, (v - LENS.cy_px) / LENS.fy_px
    k1, k2, p1, p2, k3 = LENS.distortion
    x, y = seen_x, seen_y
    for _ in range(40):
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        x, y = (
            (seen_x - 2.0 * p1 * x * y - p2 * (r2 + 2.0 * x * x)) / radial,
            (seen_y - p1 * (r2 + 2.0 * y * y) - 2.0 * p2 * x * y) / radial,
        )
    return np.column_stack((x, y, np.ones(len(x))))


def _board(cv2: object, rays: np.ndarray, rng: np.random.Generator, aside: tuple[float, float]) -> np.ndarray:
    """The picture of one pose: each pixel's ray meets the board's plane."""
    turn, _ = cv2.Rodrigues(rng.uniform(-0.45, 0.45, 3) * (1.0, 1.0, 0.4))  # type: ignore[attr-defined]
    middle = np.array([*aside, rng.uniform(0.36, 0.42)])
    normal = turn[:, 2]
    depth = normal @ middle / (rays @ normal)
    places = (rays * depth[:, None] - middle) @ turn
    x = places[:, 0] / SQUARE_M + 0.5 * (COLUMNS - 1)
    y = places[:, 1] / SQUARE_M + 0.5 * (ROWS - 1)
    is_dark = (np.floor(x) + np.floor(y)) % 2 == 0
    on_board = (np.abs(x - 0.5 * (COLUMNS - 1)) < 0.5 * (COLUMNS + 1)) & (
        np.abs(y - 0.5 * (ROWS - 1)) < 0.5 * (ROWS + 1)
    )
    grey = np.where(on_board & is_dark, 40.0, 215.0).reshape(LENS.height_px, LENS.width_px)
    soft = cv2.GaussianBlur(grey, (0, 0), 0.8)  # type: ignore[attr-defined]
    picture: np.ndarray = np.clip(soft + rng.normal(0.0, 3.0, soft.shape), 0, 255).astype(np.uint8)
    return picture
