"""What a GNSS antenna sees of the sky between buildings, and which solution its receiver makes of it."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from contract.geometry import Array
from contract.roads.model import Building
from contract.roads.walls import wall_edges

# An antenna on the roof.
ANTENNA_M = 2.3
# Of four systems together, above 10 degrees.
SATELLITES = 20
ELEVATION_RAD_MIN = math.radians(10.0)
# Across the sky in about twelve hours.
DRIFT_RADPS = math.radians(0.25) / 60.0
AZIMUTHS = 72
# The skyline is computed again after so much of a way.
MOVED_M = 0.5


@dataclass(frozen=True, slots=True)
class SkyView:
    """Satellites in view, their horizontal dilution of precision, and the share of azimuths with a wall."""

    satellites: int
    hdop: float
    walled: float


@dataclass(frozen=True, slots=True)
class Solution:
    """A kind of solution, for an HDOP of 1.

    position_std_m, heading_std_rad  as the receiver states them
    reflection_m    further error between walls on all sides, of which the receiver knows nothing
    """

    position_std_m: float
    heading_std_rad: float
    reflection_m: float


FIXED = Solution(0.012, math.radians(0.2), 0.02)
FLOATING = Solution(0.25, math.radians(0.8), 0.4)
SINGLE = Solution(1.2, math.radians(4.0), 2.5)
# Satellites that each needs, and how long carrier phases must be followed for the first.
FIXED_SATELLITES, FLOATING_SATELLITES, SINGLE_SATELLITES = 7, 5, 4
FIXED_HDOP_MAX = 2.5
FIXED_AFTER_NS = 8_000_000_000


class Sky:
    """The satellites over one map, the same for all its vehicles."""

    def __init__(self, buildings: tuple[Building, ...], rng: np.random.Generator) -> None:
        self._edges = wall_edges(buildings)
        self._tops: Array = np.array(
            [building.height_m for building in buildings for _ in building.outline], dtype=np.float64
        )
        self._azimuths = rng.uniform(0.0, 2.0 * math.pi, SATELLITES)
        # Evenly over the sky: as many low ones as its area has.
        sines = rng.uniform(math.sin(ELEVATION_RAD_MIN), math.sin(math.radians(88.0)), SATELLITES)
        self._elevations = np.arcsin(sines)

    def view(self, now_ns: int, x_m: float, y_m: float) -> SkyView:
        """From an antenna over a place in the map frame."""
        skyline = skyline_rad(self._edges, self._tops, x_m, y_m, ANTENNA_M, AZIMUTHS)
        azimuths = (self._azimuths + DRIFT_RADPS * now_ns * 1e-9) % (2.0 * math.pi)
        bins = (azimuths / (2.0 * math.pi) * AZIMUTHS).astype(np.int64) % AZIMUTHS
        seen = self._elevations > skyline[bins]
        walled = float(np.mean(skyline > ELEVATION_RAD_MIN))
        return SkyView(int(seen.sum()), _hdop(azimuths[seen], self._elevations[seen]), walled)


class SolutionFinder:
    """One receiver: which solution it has now. A fixed one needs a while of enough satellites."""

    def __init__(self, sky: Sky) -> None:
        self._sky = sky
        self._place: tuple[float, float] | None = None
        self._since_ns = 0
        self._fixable_since_ns: int | None = None
        self._view = SkyView(0, math.inf, 0.0)

    def solution(self, now_ns: int, x_m: float, y_m: float) -> tuple[Solution | None, SkyView]:
        """None: too few satellites."""
        is_first = self._place is None
        if (
            self._place is None
            or math.dist(self._place, (x_m, y_m)) > MOVED_M
            or now_ns - self._since_ns > 1_000_000_000
        ):
            self._place, self._since_ns = (x_m, y_m), now_ns
            self._view = self._sky.view(now_ns, x_m, y_m)
        view = self._view
        if view.satellites < FIXED_SATELLITES or view.hdop > FIXED_HDOP_MAX:
            self._fixable_since_ns = None
        elif self._fixable_since_ns is None:
            # A receiver that has just been switched on has done its waiting before the drive.
            self._fixable_since_ns = now_ns - FIXED_AFTER_NS if is_first else now_ns
        if self._fixable_since_ns is not None and now_ns - self._fixable_since_ns >= FIXED_AFTER_NS:
            return FIXED, view
        if view.satellites >= FLOATING_SATELLITES:
            return FLOATING, view
        return (SINGLE if view.satellites >= SINGLE_SATELLITES else None), view


def _hdop(azimuths: Array, elevations: Array) -> float:
    """Horizontal dilution of precision from lines of sight; inf for fewer than four."""
    if len(azimuths) < SINGLE_SATELLITES:
        return math.inf
    level = np.cos(elevations)
    lines = np.column_stack(
        (level * np.cos(azimuths), level * np.sin(azimuths), np.sin(elevations), np.ones(len(azimuths)))
    )
    normal = lines.T @ lines
    if np.linalg.cond(normal) > 1e9:
        return math.inf
    spread = np.linalg.inv(normal)
    return float(math.sqrt(spread[0, 0] + spread[1, 1]))


@njit(cache=True)
def skyline_rad(edges: Array, tops: Array, x: float, y: float, antenna: float, azimuths: int) -> Array:
    """(azimuths,) elevation of the highest wall in each direction, counter-clockwise from x, 0.0 for none.

    edges (n, 4) and tops (n,) of the walls, m; (x, y, antenna): the antenna's place
    """
    skyline = np.zeros(azimuths)
    for k in range(azimuths):
        angle = 2.0 * math.pi * (k + 0.5) / azimuths
        ux, uy = math.cos(angle), math.sin(angle)
        highest = 0.0
        for i in range(edges.shape[0]):
            rise = tops[i] - antenna
            if rise <= 0.0:
                continue
            ax, ay = edges[i, 0] - x, edges[i, 1] - y
            ex, ey = edges[i, 2] - edges[i, 0], edges[i, 3] - edges[i, 1]
            across = ux * ey - uy * ex
            if across == 0.0:
                continue
            distance = (ax * ey - ay * ex) / across
            share = (ax * uy - ay * ux) / across
            if distance > 0.0 and 0.0 <= share <= 1.0:
                highest = max(highest, rise / max(distance, 0.01))
        skyline[k] = math.atan(highest)
    return skyline
