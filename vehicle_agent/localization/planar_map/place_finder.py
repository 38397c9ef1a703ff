"""The search of a lost vehicle: near what it believed, farther, then the whole map; a part with each scan.

A search begins with one scan, and all its parts are compared with that scan. The places it finds are then
looked at one by one on the fine map. One that no other place comes near to is the answer.
"""

import math
from collections import deque

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.laser.pose_arrays import between, composed
from vehicle_agent.localization.monte_carlo.localization import MonteCarloLocalization, MonteCarloParams
from vehicle_agent.localization.planar_map.agreement import EvidenceParams, things_of
from vehicle_agent.localization.planar_map.field_window import FieldWindow
from vehicle_agent.localization.planar_map.hypothesis import Candidate, is_apart, refined
from vehicle_agent.localization.planar_map.place_search import (
    FoundPlace,
    PlaceSearchParams,
    places_of,
    search_grid,
)


class PlaceFinderParams(msgspec.Struct, frozen=True):
    """Parts and answers of a search.

    reaches_m, reaches_rad  half the edges of the squares around what was believed, and of their headings,
                     that are searched one after the other; then the whole map
    part_m           half the edge of a part of the whole map
    beams_of_thing   a thing counts as so many beams at most
    looked_at, looked_at_once  best places that are looked at on the fine map, and how many with one scan
    lead             what speaks for the best place has to be more than for any other by so much
    balance_min      and so much has to be left of it after what speaks against it
    """

    search: PlaceSearchParams = PlaceSearchParams()
    reaches_m: tuple[float, ...] = (12.0, 36.0)
    reaches_rad: tuple[float, ...] = (0.6, 3.2)
    part_m: float = 48.0
    beams_of_thing: float = 4.0
    looked_at: int = 6
    looked_at_once: int = 2
    lead: float = 2.0
    balance_min: float = 3.0


class Part(msgspec.Struct, frozen=True):
    """A square of the map: its middle and half its edge, m; headings: middle and half of them, rad."""

    x_m: float
    y_m: float
    half_m: float
    yaw_rad: float
    half_rad: float


class PlaceFinder:
    """One search: `step` with each scan until it `is_over`; `found` is then its answer, if it has one."""

    def __init__(
        self, window: FieldWindow, particles: MonteCarloParams, evidence: EvidenceParams,
        params: PlaceFinderParams, points: Array, reckoned: Array, parts: list[Part],
    ) -> None:  # fmt: skip
        """points (m, 2): ends of the beams, laser frame; reckoned (3,): the laser by dead reckoning."""
        self._window, self._particles, self._evidence, self._params = window, particles, evidence, params
        self._points, self._reckoned = points, np.array(reckoned, dtype=np.float64)
        things = things_of(points, evidence)
        sizes = np.bincount(things) if len(things) else np.zeros(0)
        # A long wall says more of the place than a post, but not as much more as it has beams.
        of_things = np.minimum(1.0, params.beams_of_thing / np.maximum(sizes, 1.0))
        self._weights: Array = of_things[things] if len(things) else np.zeros(0)
        self._parts = deque(parts)
        self._places: list[FoundPlace] = []
        self._open: deque[FoundPlace] | None = None
        self.candidates: list[Candidate] = []

    @property
    def is_over(self) -> bool:
        return self._open is not None and not self._open

    def step(self) -> None:
        """One part of the map, or one or two places on the fine map."""
        if self._parts:
            self._search(self._parts.popleft())
        elif self._open is None:
            self._open = deque(self._apart()[: self._params.looked_at])
        for _ in range(self._params.looked_at_once):
            if self._open:
                self._look_at(self._open.popleft())

    def _apart(self) -> list[FoundPlace]:
        """What the parts have found, best first, without what lies beside better places."""
        found: list[FoundPlace] = []
        search = self._params.search
        for place in sorted(self._places, key=lambda place: -place.score):
            if all(is_apart(place.pose, other.pose, search.apart_m, search.apart_rad) for other in found):
                found.append(place)
        return found

    def found(
        self, reckoned: Array, lead: float | None = None, balance_min: float | None = None
    ) -> Array | None:
        """(3,) where the laser is now, if one stands out; lead, balance_min: in place of the parameters."""
        params = self._params
        best = max(self.candidates, key=lambda candidate: candidate.balance, default=None)
        lead = params.lead if lead is None else lead
        if best is None or best.balance < (params.balance_min if balance_min is None else balance_min):
            return None
        search = params.search
        for other in self.candidates:
            if (
                is_apart(other.pose, best.pose, search.apart_m, search.apart_rad)
                and other.balance > best.balance - lead
            ):
                return None
        pose: Array = composed(best.pose, between(self._reckoned, np.asarray(reckoned, dtype=np.float64)))
        return pose

    def _search(self, part: Part) -> None:
        window, search = self._window, self._params.search
        tile_m = window.tiles.tile_m
        edge_m = window.tiles.cell_m * search.pooled * 2.0 ** (search.levels - 1)
        reach_m = part.half_m + search.range_m + edge_m
        first = (math.floor((part.x_m - reach_m) / tile_m), math.floor((part.y_m - reach_m) / tile_m))
        last = (math.floor((part.x_m + reach_m) / tile_m), math.floor((part.y_m + reach_m) / tile_m))
        cells = window.cells(first, last)
        grid = search_grid(cells, window.tiles.cell_m, first[0] * tile_m, first[1] * tile_m, search)
        best = max((place.score for place in self._places), default=0.0)
        self._places += places_of(
            self._points, self._weights, grid, (part.x_m, part.y_m, part.half_m),
            (part.yaw_rad, part.half_rad), best - search.margin, search,
        )  # fmt: skip

    def _look_at(self, place: FoundPlace) -> None:
        field = self._window.around(float(place.pose[0]), float(place.pose[1]))
        if field is not None:
            filter_ = MonteCarloLocalization(field, self._particles)
            self.candidates.append(refined(place.pose, self._points, filter_, self._evidence))


def nearby(pose: Array, params: PlaceFinderParams) -> list[list[Part]]:
    """The parts of the searches around a pose (3,), one search after the other."""
    x_m, y_m, yaw_rad = (float(value) for value in pose)
    reaches = zip(params.reaches_m, params.reaches_rad, strict=True)
    return [[Part(x_m, y_m, half_m, yaw_rad, half_rad)] for half_m, half_rad in reaches]


def everywhere(window: FieldWindow, near: Array | None, params: PlaceFinderParams) -> list[Part]:
    """The parts of the whole map; near (3,): those about this pose first."""
    edge_m, tile_m = 2.0 * params.part_m, window.tiles.tile_m
    # A tile that lies on two squares is in both.
    squares = {
        (math.floor((ix + dx) * tile_m / edge_m), math.floor((iy + dy) * tile_m / edge_m))
        for ix, iy in window.tiles.places
        for dx in (0.01, 0.99)
        for dy in (0.01, 0.99)
    }
    middles = sorted(((column + 0.5) * edge_m, (row + 0.5) * edge_m) for column, row in squares)
    if near is not None:
        middles.sort(key=lambda middle: math.hypot(middle[0] - near[0], middle[1] - near[1]))
    return [Part(x_m, y_m, params.part_m, 0.0, math.pi) for x_m, y_m in middles]
