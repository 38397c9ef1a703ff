"""Buildings: facades with windows set back, piers, doors and columns."""

import math

import numpy as np

from contract.geometry import Array
from contract.roads.model import Building
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.mesh import Mesh, quads

_STOREY_M = 3.3
_SILL_M = 0.9
_WINDOW_TOP_M = 2.5
# A shorter wall has no window.
_FACADE_M_MIN = 4.0
_BELOW_M = 0.6
_DOOR_M = (1.6, 2.4)


def altered_buildings(buildings: tuple[Building, ...], changes: WorldChanges) -> tuple[Building, ...]:
    """The world's buildings: some of the map's are gone, lower or higher, or have an annex."""
    if changes.buildings_altered_ratio <= 0.0:
        return buildings
    rng = np.random.default_rng([changes.seed, *b"buildings"])
    world: list[Building] = []
    for building in buildings:
        # Always the same draws, so that another share alters the same buildings first.
        chance, kind, size, side = rng.random(4)
        if chance >= changes.buildings_altered_ratio:
            world.append(building)
        elif kind < 0.6:
            world += [building, _annex(building, size, side)]
        elif kind < 0.85:
            height_m = max(4.0, building.height_m + 6.0 * (size - 0.5))
            world.append(Building(building.outline, height_m, building.name))
    return tuple(world)


def _annex(building: Building, size: float, side: float) -> Building:
    """A porch or shed of 1 to 4 m before the middle of one wall."""
    outline = np.array(building.outline)
    lengths = np.hypot(*(np.roll(outline, -1, axis=0) - outline).T)
    longest = np.argsort(-lengths, kind="stable")[: max(1, min(4, len(outline)))]
    k = int(longest[int(side * len(longest))])
    a, b = outline[k], outline[(k + 1) % len(outline)]
    along = (b - a) / max(float(np.hypot(*(b - a))), 1e-6)
    out = np.array([along[1], -along[0]]) * _turn(outline)
    middle, half, depth = 0.5 * (a + b), 0.3 * lengths[k], 1.0 + 3.0 * size
    corners = [middle - half * along, middle + half * along]
    corners += [corners[1] + depth * out, corners[0] + depth * out]
    return Building(tuple((float(x), float(y)) for x, y in corners), 3.0 + size, "")


def add_buildings(mesh: Mesh, ground: Ground, buildings: tuple[Building, ...], seed: int) -> None:
    """All facades and roofs; a building looks the same whatever others there are."""
    for building in buildings:
        outline = np.array(building.outline, dtype=np.float64)
        if len(outline) < 3:
            continue
        rng = np.random.default_rng([seed, *b"facade", *np.rint(np.abs(outline[:2].ravel())).astype(int)])
        material = Material.PLASTER if rng.random() < 0.6 else Material.BRICK
        shade = float(rng.uniform(0.75, 1.25))
        depth, pitch = float(rng.uniform(0.12, 0.3)), float(rng.uniform(2.6, 4.2))
        columns = rng.random() < 0.3
        heights = ground.terrain_m(outline[:, 0], outline[:, 1])
        floor = float(heights.max()) + ground.params.kerb_m
        below = float(heights.min()) - _BELOW_M
        turn = _turn(outline)
        ends = outline if turn > 0.0 else outline[::-1]
        for a, b in zip(ends, np.roll(ends, -1, axis=0), strict=True):
            facade = _Facade(a, b, below, floor, floor + building.height_m)
            if facade.length_m < _FACADE_M_MIN or building.height_m < 3.0:
                mesh.add(facade.panels([(0.0, facade.length_m, below, facade.top, 0.0)]), material, shade)
                continue
            facade.add(mesh, material, shade, depth, pitch, columns, rng)


class _Facade:
    """One wall from a to b, its outer side to the right; below the ground and the top are heights."""

    def __init__(self, a: Array, b: Array, below: float, floor: float, top: float) -> None:
        self._a, self.below, self.floor, self.top = a, below, floor, top
        self.length_m = float(np.hypot(*(b - a)))
        self._along = (b - a) / max(self.length_m, 1e-9)
        self._out = np.array([self._along[1], -self._along[0]])

    def add(
        self,
        mesh: Mesh,
        material: Material,
        shade: float,
        depth: float,
        pitch: float,
        has_columns: bool,
        rng: np.random.Generator,
    ) -> None:
        """Panes lie `depth` behind bands between storeys and piers between windows."""
        storeys = max(1, math.floor((self.top - self.floor) / _STOREY_M))
        bays = max(1, round(self.length_m / pitch))
        width = self.length_m / bays
        half_pier = 0.5 * width * 0.4
        u = width * np.arange(bays + 1)
        bases = self.floor + _STOREY_M * np.arange(storeys)
        mesh.add(self.panels([(0.0, self.length_m, self.floor, self.top, -depth)]), Material.GLASS, 1.0)
        # Bands: from below to the first sill, between storeys, from the last window to the top.
        lows = np.concatenate(([self.below], bases + _WINDOW_TOP_M))
        highs = np.concatenate((bases + _SILL_M, [self.top]))
        bands = [(0.0, self.length_m, low, high, 0.0) for low, high in zip(lows, highs, strict=True)]
        mesh.add(self.panels(bands), material, shade)
        ledges = [self._ledge(high, depth) for high in highs[:-1]] + [
            self._ledge(low, depth) for low in lows[1:]
        ]
        mesh.add(np.concatenate(ledges), material, shade)
        piers, cheeks = [], []
        for base in bases:
            low, high = base + _SILL_M, base + _WINDOW_TOP_M
            for at in u:
                left, right = max(0.0, at - half_pier), min(self.length_m, at + half_pier)
                piers.append((left, right, low, high, 0.0))
                cheeks += [self._cheek(left, low, high, depth), self._cheek(right, low, high, depth)]
        mesh.add(self.panels(piers), material, shade)
        mesh.add(quads(np.array(cheeks)), material, shade)
        if has_columns:
            standing = [(at - 0.2, at + 0.2, self.below, self.floor + _STOREY_M, 0.45) for at in u[1:-1]]
            if standing:
                mesh.add(self.panels(standing), Material.PLASTER, shade)
                sides = [
                    self._cheek(x, self.below, self.floor + _STOREY_M, 0.45, 0.45)
                    for at in u[1:-1]
                    for x in (at - 0.2, at + 0.2)
                ]
                mesh.add(quads(np.array(sides)), Material.PLASTER, shade)
        if self.length_m > 8.0 and rng.random() < 0.5:
            at = width * (int(rng.integers(0, bays)) + 0.5)
            # A door leaf stands before its frame.
            half, top = 0.5 * _DOOR_M[0], self.floor + _DOOR_M[1]
            mesh.add(self.panels([(at - half, at + half, self.below, top, 0.06)]), Material.WOOD, shade)

    def panels(self, rows: list[tuple[float, float, float, float, float]]) -> Array:
        """Triangles of upright rectangles: from, to along the wall; low, high; how far before the wall."""
        table = np.array(rows, dtype=np.float64)
        corners = np.empty((len(table), 4, 3))
        for k, (end, level) in enumerate(((0, 2), (1, 2), (1, 3), (0, 3))):
            corners[:, k, :2] = self._a + table[:, end, None] * self._along + table[:, 4, None] * self._out
            corners[:, k, 2] = table[:, level]
        return quads(corners)

    def _ledge(self, level: float, depth: float) -> Array:
        """A sill or lintel between the wall and the panes."""
        ends = [self._a, self._a + self.length_m * self._along]
        ends += [ends[1] - depth * self._out, ends[0] - depth * self._out]
        return quads(np.array([[(*end, level) for end in ends]]))

    def _cheek(self, at: float, low: float, high: float, depth: float, before: float = 0.0) -> list[Array]:
        """The side of a pier: from `before` the wall back by `depth`."""
        front = self._a + at * self._along + before * self._out
        back = front - depth * self._out
        return [
            np.array([*front, low]),
            np.array([*back, low]),
            np.array([*back, high]),
            np.array([*front, high]),
        ]


def _turn(outline: Array) -> float:
    """1.0 for an outline that runs counter-clockwise, else -1.0."""
    x, y = outline.T
    return 1.0 if float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) > 0.0 else -1.0
