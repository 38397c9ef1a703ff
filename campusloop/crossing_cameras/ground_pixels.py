"""Where pixels of a fixed camera lie on the ground: a homography by four points."""

from collections.abc import Sequence

import numpy as np

from contract.geometry import Array

# Four points that nearly lie on a line say little across it.
_CONDITION_MAX = 1e7
_PERSON_M = 1.7
# Seen from above at 20 degrees, a person is that much shorter.
_TILT_RATIO = 0.94
_STEP_M = 0.1


class MappingError(Exception):
    """The points give no mapping; the message says which rule they break."""


class GroundPixels:
    """Pixels (column, row) and places (x, y, m, map frame) of the same ground.

    T_map_pixel  (3, 3) homography from pixels to places
    """

    def __init__(
        self, pixels: Sequence[tuple[float, float]], places_map: Sequence[tuple[float, float]]
    ) -> None:
        """Raises MappingError unless four or more pairs of points are given, no three of them on a line."""
        if len(pixels) != len(places_map) or len(pixels) < 4:
            raise MappingError(
                "give at least four points, each in the picture and on the map, "
                f"not {len(pixels)} and {len(places_map)}"
            )
        source, target = np.array(pixels, dtype=np.float64), np.array(places_map, dtype=np.float64)
        if not (np.isfinite(source).all() and np.isfinite(target).all()):
            raise MappingError("the points must be finite numbers")
        from_pixel, to_place = _centred(source), _centred(target)
        rows = []
        for (u, v), (x, y) in zip(_apply(from_pixel, source), _apply(to_place, target), strict=True):
            rows.append([u, v, 1.0, 0.0, 0.0, 0.0, -x * u, -x * v, -x])
            rows.append([0.0, 0.0, 0.0, u, v, 1.0, -y * u, -y * v, -y])
        # Direct linear transform, Hartley and Zisserman (2004), algorithm 4.2.
        _, sizes, across = np.linalg.svd(np.array(rows))
        H = across[-1].reshape(3, 3)
        if sizes[7] < 1e-4 * sizes[0] or np.linalg.cond(H) > _CONDITION_MAX:
            raise MappingError(
                "three of the points lie on a line, in the picture or on the map; choose others"
            )
        self.T_map_pixel: Array = np.linalg.inv(to_place) @ H @ from_pixel
        self._T_pixel_map: Array = np.linalg.inv(self.T_map_pixel)
        depth = self._T_pixel_map @ np.append(target.mean(axis=0), 1.0)
        if depth[2] < 0.0:
            self._T_pixel_map = -self._T_pixel_map
        if (np.column_stack((target, np.ones(len(target)))) @ self._T_pixel_map[2] <= 0.0).any():
            raise MappingError("the points are on both sides of the horizon: are two of them exchanged?")

    def places(self, pixels: Array) -> Array:
        """(n, 2) on the map of pixels (n, 2)."""
        return _apply(self.T_map_pixel, pixels)

    def pixels(self, places_map: Array) -> Array:
        """(n, 2) in the picture of places (n, 2); NaN behind the camera."""
        points = np.column_stack((places_map, np.ones(len(places_map)))) @ self._T_pixel_map.T
        ahead = points[:, 2] > 1e-9
        return np.where(ahead[:, None], points[:, :2] / np.where(ahead, points[:, 2], 1.0)[:, None], np.nan)

    def person_heights_px(self, places_map: Array) -> Array:
        """(n,) how high a person is in the picture who stands at places (n, 2).

        The camera is level: a metre along the picture's rows is as long as one upright, but for the tilt.
        """
        here = self.pixels(places_map)
        along = self.pixels(places_map + np.array([_STEP_M, 0.0])) - here
        across = self.pixels(places_map + np.array([0.0, _STEP_M])) - here
        # The way on the ground that stays on one row: a along + b across with no change of the row.
        a, b = across[:, 1], -along[:, 1]
        length = np.maximum(np.hypot(a, b), 1e-12)
        per_step = np.abs(a * along[:, 0] + b * across[:, 0]) / length
        heights: Array = _TILT_RATIO * _PERSON_M / _STEP_M * per_step
        return heights


def _centred(points: Array) -> Array:
    """(3, 3) moves points to their middle and to a mean distance of 1, for equations of like sizes."""
    middle = points.mean(axis=0)
    scale = 1.0 / max(1e-9, float(np.linalg.norm(points - middle, axis=1).mean()))
    return np.array([[scale, 0.0, -scale * middle[0]], [0.0, scale, -scale * middle[1]], [0.0, 0.0, 1.0]])


def _apply(H: Array, points: Array) -> Array:
    moved = np.column_stack((points, np.ones(len(points)))) @ H.T
    return moved[:, :2] / moved[:, 2:]
