"""Which vehicles are near each other, from their latest positions."""

import math
from collections import defaultdict

Cell = tuple[int, int]


class Nearby:
    """Positions in square cells, so that a search looks at near cells only."""

    def __init__(self, radius_m: float) -> None:
        self._radius_m = radius_m
        self._places: dict[str, tuple[float, float]] = {}
        self._cells: defaultdict[Cell, set[str]] = defaultdict(set)

    def move(self, vehicle_id: str, x_m: float, y_m: float) -> list[str]:
        """Move the vehicle there. Returns the others within the radius, by id."""
        self.remove(vehicle_id)
        cell = self._cell(x_m, y_m)
        self._places[vehicle_id] = (x_m, y_m)
        self._cells[cell].add(vehicle_id)
        return [other for other in self.around(x_m, y_m) if other != vehicle_id]

    def around(self, x_m: float, y_m: float) -> list[str]:
        """The vehicles within the radius of a place, by id."""
        cell = self._cell(x_m, y_m)
        return sorted(
            other
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
            for other in self._cells.get((cell[0] + i, cell[1] + j), ())
            if math.dist(self._places[other], (x_m, y_m)) <= self._radius_m
        )

    def remove(self, vehicle_id: str) -> None:
        """Forget the vehicle, if it is known."""
        place = self._places.pop(vehicle_id, None)
        if place is not None:
            cell = self._cell(*place)
            self._cells[cell].discard(vehicle_id)
            if not self._cells[cell]:
                del self._cells[cell]

    def _cell(self, x_m: float, y_m: float) -> Cell:
        return math.floor(x_m / self._radius_m), math.floor(y_m / self._radius_m)
