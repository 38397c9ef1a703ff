"""What the pose graph of a drive came to."""

import msgspec

from workshop.cloud_mapping.pose_graph import Edge, Optimized, Place


class Solved(msgspec.Struct, frozen=True):
    """The graph at last, what it consists of, and how long its optimizations took (CPU seconds)."""

    graph: Optimized
    edges: tuple[Edge, ...]
    places: tuple[Place, ...]
    tried: int
    optimise_s: float
