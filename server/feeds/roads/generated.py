"""Made-up campuses as OpenStreetMap XML, for tests and soak runs: a jittered grid with dead ends."""

import math
import random
from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

import numpy as np

from contract.roads.model import Origin
from contract.roads.projection import wgs84_from_map

_ORIGIN = Origin(31.0, 121.0)
_BLOCK_M = 120.0
_JITTER_M = 18.0
_VERTEX_M = 30.0
_NOISE_M = 0.8
_BORDER_M = 60.0
_LEAST_DEAD_ENDS, _MOST_DEAD_ENDS = 4, 7

Point = tuple[float, float]


@dataclass(slots=True)
class _Sketch:
    """The file in the making, in metres; ids count up from 1 in one range for nodes and ways."""

    rng: random.Random
    nodes: dict[int, tuple[Point, dict[str, str]]] = field(default_factory=dict)
    ways: dict[int, tuple[list[int], dict[str, str]]] = field(default_factory=dict)

    def node(self, point: Point, **tags: str) -> int:
        node_id = len(self.nodes) + 1
        self.nodes[node_id] = (point, tags)
        return node_id

    def way(self, refs: list[int], **tags: str) -> None:
        self.ways[10_000 + len(self.ways)] = (refs, tags)

    def road(self, first: int, last: int, **tags: str) -> None:
        """A road of small bends between two nodes."""
        a, b = self.nodes[first][0], self.nodes[last][0]
        steps = max(1, round(math.dist(a, b) / _VERTEX_M))
        between = [
            self.node(
                (
                    a[0] + (b[0] - a[0]) * k / steps + self.rng.gauss(0.0, _NOISE_M),
                    a[1] + (b[1] - a[1]) * k / steps + self.rng.gauss(0.0, _NOISE_M),
                )
            )
            for k in range(1, steps)
        ]
        self.way([first, *between, last], **tags)


def generated_osm(seed: int) -> bytes:
    """An OSM XML file with one campus, equal for equal seeds.

    Two to three by three blocks of narrow two-way roads, a few of them wide or missing, with four to seven
    dead ends (some tagged as turning circles), named buildings, a private road and a footway. Odd seeds put
    ways before nodes.
    """
    sketch = _Sketch(random.Random(seed))
    corners = _grid(sketch)
    _dead_ends(sketch, corners)
    _buildings(sketch, corners)
    crossing = list(corners.values())
    far = sketch.node((_BLOCK_M / 2.0, -_BORDER_M))
    sketch.way([crossing[0], far], highway="service", access="private")
    sketch.way([crossing[1], far], highway="footway")
    return _xml(sketch, ways_first=seed % 2 == 1)


def _grid(sketch: _Sketch) -> dict[tuple[int, int], int]:
    rng = sketch.rng
    columns, rows = rng.choice((3, 4)), 3
    corners = {
        (i, j): sketch.node(
            (
                i * _BLOCK_M + rng.uniform(-_JITTER_M, _JITTER_M),
                j * _BLOCK_M + rng.uniform(-_JITTER_M, _JITTER_M),
            )
        )
        for i in range(columns)
        for j in range(rows)
    }
    # The rim stays whole, so that there is a circuit; inner roads may be missing.
    for (i, j), here in corners.items():
        for di, dj in ((1, 0), (0, 1)):
            there = corners.get((i + di, j + dj))
            if there is None:
                continue
            rim = (dj == 0 and j in (0, rows - 1)) or (di == 0 and i in (0, columns - 1))
            if not rim and rng.random() < 0.3:
                continue
            wide = {"lanes": "2"} if rng.random() < 0.2 else {}
            sketch.road(here, there, highway="service", name=f"Road {i}{j}{'EN'[dj]}", **wide)
    return corners


def _dead_ends(sketch: _Sketch, corners: dict[tuple[int, int], int]) -> None:
    rng = sketch.rng
    last_column, last_row = max(i for i, _ in corners), max(j for _, j in corners)
    outward = []
    for (i, j), node_id in corners.items():
        if i in (0, last_column):
            outward.append((node_id, (-1.0 if i == 0 else 1.0, 0.0)))
        elif j in (0, last_row):
            outward.append((node_id, (0.0, -1.0 if j == 0 else 1.0)))
    rng.shuffle(outward)
    for node_id, (dx, dy) in outward[: rng.randint(_LEAST_DEAD_ENDS, _MOST_DEAD_ENDS)]:
        x, y = sketch.nodes[node_id][0]
        length = rng.uniform(45.0, 90.0)
        tags = {"highway": "turning_circle"} if rng.random() < 0.5 else {}
        end = sketch.node((x + dx * length, y + dy * length), **tags)
        sketch.road(node_id, end, highway="service")


def _buildings(sketch: _Sketch, corners: dict[tuple[int, int], int]) -> None:
    """A named block beside the middle of each cell."""
    for number, (i, j) in enumerate(cell for cell in corners if (cell[0] + 1, cell[1] + 1) in corners):
        x, y = (i + 0.5) * _BLOCK_M, (j + 0.5) * _BLOCK_M
        w, h = sketch.rng.uniform(12.0, 25.0), sketch.rng.uniform(12.0, 25.0)
        ring = [sketch.node((x + a * w, y + b * h)) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        sketch.way([*ring, ring[0]], building="yes", name=f"Hall {chr(65 + number)}")


def _xml(sketch: _Sketch, *, ways_first: bool) -> bytes:
    points = np.array([point for point, _ in sketch.nodes.values()])
    latitude, longitude = wgs84_from_map(_ORIGIN, points)
    nodes = [
        f'<node id="{node_id}" lat="{lat:.9f}" lon="{lon:.9f}" version="1">{_tags(tags)}</node>'
        for (node_id, (_, tags)), lat, lon in zip(sketch.nodes.items(), latitude, longitude, strict=True)
    ]
    ways = [
        f'<way id="{way_id}" version="1">'
        + "".join(f'<nd ref="{ref}"/>' for ref in refs)
        + f"{_tags(tags)}</way>"
        for way_id, (refs, tags) in sketch.ways.items()
    ]
    corners = np.array([points.min(axis=0) - 100.0, points.max(axis=0) + 100.0])
    south_north, west_east = wgs84_from_map(_ORIGIN, corners)
    bounds = (
        f'<bounds minlat="{south_north[0]:.7f}" minlon="{west_east[0]:.7f}" '
        f'maxlat="{south_north[1]:.7f}" maxlon="{west_east[1]:.7f}"/>'
    )
    body = [*ways, *nodes] if ways_first else [*nodes, *ways]
    text = "\n".join(['<?xml version="1.0"?>', '<osm version="0.6">', bounds, *body, "</osm>", ""])
    return text.encode()


def _tags(tags: dict[str, str]) -> str:
    return "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in tags.items())
