"""Ray casting from one point to the ground, upright boxes and upright cylinders.

A fan of rays is rings x columns: ring r has one elevation, column c one azimuth, both in the base frame.
Ranges are along the ray. Boxes are rows (x, y, yaw, rear, front, half_width, height), cylinders rows
(x, y, radius, height), all standing on z = 0 of the map frame.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array

Array32 = NDArray[np.float32]
Kinds = NDArray[np.int8]

NOTHING, GROUND, WALL, PERSON, VEHICLE = 0, 1, 2, 3, 4
BOX_COLUMNS = 7
TWO_PI = 2.0 * math.pi


@njit(cache=True)
def ground_ranges(
    sin_el: Array, columns: int, height_m: float, range_max_m: float, ranges: Array32, kinds: Kinds
) -> None:
    """Range to flat ground below the sensor, range_max_m where it is not reached."""
    for r in range(sin_el.shape[0]):
        reach = range_max_m
        if sin_el[r] < 0.0:
            reach = min(reach, -height_m / sin_el[r])
        hit = reach < range_max_m
        for c in range(columns):
            ranges[r * columns + c] = reach
            kinds[r * columns + c] = GROUND if hit else NOTHING


@njit(cache=True)
def hit_boxes(
    boxes: Array,
    sensor: Array,
    yaw_rad: float,
    cos_el: Array,
    sin_el: Array,
    columns: int,
    ranges: Array32,
    kinds: Kinds,
) -> None:
    """Shorten ranges at boxes; sensor (3,) position in the frame of the boxes."""
    for b in range(boxes.shape[0]):
        x, y, yaw, rear, front, half, height = boxes[b]
        cb, sb = math.cos(yaw), math.sin(yaw)
        dx, dy = sensor[0] - x, sensor[1] - y
        ox, oy = cb * dx + sb * dy, -sb * dx + cb * dy
        first, count = _columns_of_box(ox, oy, rear, front, half, yaw - yaw_rad, columns)
        for j in range(count):
            c = (first + j) % columns
            azimuth = TWO_PI * c / columns + yaw_rad - yaw
            near, far = _slab(ox, oy, math.cos(azimuth), math.sin(azimuth), rear, front, half)
            if far < near or far <= 0.0:
                continue
            for r in range(cos_el.shape[0]):
                _shorten(
                    near,
                    far,
                    height - sensor[2],
                    cos_el[r],
                    sin_el[r],
                    r * columns + c,
                    VEHICLE,
                    ranges,
                    kinds,
                )


@njit(cache=True)
def hit_cylinders(
    cylinders: Array,
    sensor: Array,
    yaw_rad: float,
    cos_el: Array,
    sin_el: Array,
    columns: int,
    ranges: Array32,
    kinds: Kinds,
) -> None:
    """Shorten ranges at cylinders; sensor (3,) position in the frame of the cylinders."""
    for i in range(cylinders.shape[0]):
        x, y, radius, height = cylinders[i]
        dx, dy = x - sensor[0], y - sensor[1]
        distance = math.hypot(dx, dy)
        if distance <= radius:
            continue
        bearing = math.atan2(dy, dx) - yaw_rad
        spread = math.asin(radius / distance)
        first = math.ceil((bearing - spread) / TWO_PI * columns)
        last = math.floor((bearing + spread) / TWO_PI * columns)
        for j in range(first, last + 1):
            off = distance * math.sin(TWO_PI * j / columns - bearing)
            along = distance * math.cos(TWO_PI * j / columns - bearing)
            half_chord = math.sqrt(max(0.0, radius * radius - off * off))
            c = j % columns
            for r in range(cos_el.shape[0]):
                _shorten(
                    along - half_chord,
                    along + half_chord,
                    height - sensor[2],
                    cos_el[r],
                    sin_el[r],
                    r * columns + c,
                    PERSON,
                    ranges,
                    kinds,
                )


@njit(cache=True)
def _shorten(
    near: float,
    far: float,
    top: float,
    cos_el: float,
    sin_el: float,
    k: int,
    kind: int,
    ranges: Array32,
    kinds: Kinds,
) -> None:
    """Shorten a ray that passes over an object's footprint between horizontal distances near and far.

    top: the object's top above the sensor. The ray hits its side, or its top from above.
    """
    at = max(near, 0.0)
    rise = at * sin_el / cos_el
    if rise > top:
        if sin_el >= 0.0:
            return
        at = top * cos_el / sin_el
        if at > far:
            return
    reach = at / cos_el
    if reach < ranges[k]:
        ranges[k] = reach
        kinds[k] = kind


@njit(cache=True)
def _slab(
    ox: float, oy: float, ux: float, uy: float, rear: float, front: float, half: float
) -> tuple[float, float]:
    """Horizontal entry and exit distance of a ray from (ox, oy) along (ux, uy) through a rectangle."""
    near, far = -np.inf, np.inf
    for o, u, low, high in ((ox, ux, -rear, front), (oy, uy, -half, half)):
        if abs(u) < 1e-12:
            if o < low or o > high:
                return np.inf, -np.inf
            continue
        a, b = (low - o) / u, (high - o) / u
        near, far = max(near, min(a, b)), min(far, max(a, b))
    return near, far


@njit(cache=True)
def _columns_of_box(
    ox: float, oy: float, rear: float, front: float, half: float, turn: float, columns: int
) -> tuple[int, int]:
    """First column and count of columns that can meet the rectangle; `turn` is its yaw in the base frame."""
    if -rear <= ox <= front and abs(oy) <= half:
        return 0, columns
    middle = math.atan2(-oy, 0.5 * (front - rear) - ox)
    low, high = 0.0, 0.0
    for cx in (-rear, front):
        for cy in (-half, half):
            delta = math.atan2(cy - oy, cx - ox) - middle
            delta -= TWO_PI * math.floor(delta / TWO_PI + 0.5)
            low, high = min(low, delta), max(high, delta)
    first = math.ceil((middle + turn + low) / TWO_PI * columns)
    last = math.floor((middle + turn + high) / TWO_PI * columns)
    return first, max(0, last - first + 1)


@njit(cache=True)
def points_from_ranges(
    cos_el: Array,
    sin_el: Array,
    columns: int,
    mount: Array,
    ranges: Array32,
    kinds: Kinds,
    noise: Array32,
    kept: Array32,
    dropout: float,
    range_min_m: float,
    reflectivity: Array32,
) -> tuple[Array32, Array32]:
    """Returns in the base frame: points (n, 3) and intensities (n,), ring by ring.

    noise (rays,) metres along the ray; a ray is lost where kept < dropout or its range is below range_min_m.
    """
    rays = ranges.shape[0]
    points = np.empty((rays, 3), dtype=np.float32)
    intensities = np.empty(rays, dtype=np.float32)
    cos_az, sin_az = np.empty(columns), np.empty(columns)
    for c in range(columns):
        cos_az[c], sin_az[c] = math.cos(TWO_PI * c / columns), math.sin(TWO_PI * c / columns)
    n = 0
    for k in range(rays):
        if kinds[k] == NOTHING or kept[k] < dropout or ranges[k] < range_min_m:
            continue
        r, c = k // columns, k % columns
        reach = ranges[k] + noise[k]
        points[n, 0] = mount[0] + reach * cos_el[r] * cos_az[c]
        points[n, 1] = mount[1] + reach * cos_el[r] * sin_az[c]
        points[n, 2] = mount[2] + reach * sin_el[r]
        intensities[n] = reflectivity[kinds[k]]
        n += 1
    return points[:n].copy(), intensities[:n].copy()
