"""What stands on the ground: where a shuttle that leaves the drawn line must not go."""

from collections.abc import Sequence

import shapely

from contract.geometry import Array


class Ground:
    """Buildings and water as polygons in the map frame."""

    def __init__(self, obstacles: Sequence[shapely.Polygon]) -> None:
        self._obstacles = list(obstacles)
        self._tree = shapely.STRtree(self._obstacles)

    def hits(self, points: Array, half_width_m: float, *, beside: Array | None = None) -> bool:
        """A body of this half width touches an obstacle along the line.

        beside  an obstacle that this drawn line itself runs through does not count: a road passes under it
        """
        swept = shapely.LineString(points).buffer(half_width_m)
        touched = self._tree.query(swept, predicate="intersects")
        if beside is None or len(touched) == 0:
            return len(touched) > 0
        drawn = shapely.LineString(beside)
        return any(not drawn.intersects(self._obstacles[int(i)]) for i in touched)
