"""How well a map's parts agree: what a person reads before trusting the map."""

from collections.abc import Sequence

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.laser.pose_arrays import between
from workshop.laser_mapping.keyframes import DeadReckoned
from workshop.laser_mapping.loops import Loops
from workshop.laser_mapping.pose_graph import Edge
from workshop.laser_mapping.refinement import Refined

# A loop edge with less weight contradicts the rest of the graph.
_REJECTED_WEIGHT = 0.1


class Residuals(msgspec.Struct, frozen=True):
    """Counts and deviations.

    scans, scans_matched, scans_poor  read; matched by dead reckoning; matched with too few inliers
    way_m                 length of the way
    keyframes, loops_tried, loops_closed, loops_rejected   the last: without weight in the graph
    passes, passes_rejected        matches between passes of one place; how many the graph gave no weight
    pass_median_m, pass_p95_m      how far the final poses deviate from these matches
    pass_median_deg, pass_p95_deg
    loop_correction_m     farthest that loop closure moved a keyframe against dead reckoning
    """

    scans: int
    scans_matched: int
    scans_poor: int
    way_m: float
    keyframes: int
    loops_tried: int
    loops_closed: int
    loops_rejected: int
    passes: int
    passes_rejected: int
    pass_median_m: float
    pass_p95_m: float
    pass_median_deg: float
    pass_p95_deg: float
    loop_correction_m: float


def residuals(reckoned: DeadReckoned, loops: Loops, refined: Refined, way_m: float) -> Residuals:
    """Of one finished map. Deviations are 0 where no place was passed twice."""
    keyframes = reckoned.keyframes
    chained, closed = len(keyframes.edges), len(loops.edges)
    weights = refined.graph.weights
    # Edges are in the order: dead reckoning, passes, loops.
    pass_edges = refined.edges[chained : len(refined.edges) - closed]
    pass_weights = weights[chained : len(weights) - closed]
    loop_weights = weights[len(weights) - closed :]
    used = [edge for edge, weight in zip(pass_edges, pass_weights, strict=True) if weight >= _REJECTED_WEIGHT]
    deviations_m, deviations_deg = pass_deviations(refined.graph.poses, used)
    moved = refined.graph.poses[:, :2] - keyframes.poses[:, :2]
    return Residuals(
        scans=len(reckoned.poses),
        scans_matched=reckoned.matched,
        scans_poor=reckoned.poor,
        way_m=way_m,
        keyframes=len(keyframes),
        loops_tried=loops.tried,
        loops_closed=closed,
        loops_rejected=int((loop_weights < _REJECTED_WEIGHT).sum()),
        passes=len(pass_edges),
        passes_rejected=len(pass_edges) - len(used),
        pass_median_m=float(np.median(deviations_m)),
        pass_p95_m=float(np.percentile(deviations_m, 95)),
        pass_median_deg=float(np.median(deviations_deg)),
        pass_p95_deg=float(np.percentile(deviations_deg, 95)),
        loop_correction_m=float(np.hypot(moved[:, 0], moved[:, 1]).max()),
    )


def pass_deviations(poses: Array, edges: Sequence[Edge]) -> tuple[Array, Array]:
    """(metres (e,), degrees (e,)) between what each edge measured and the poses; one zero without edges."""
    if not edges:
        return np.zeros(1), np.zeros(1)
    first, last = poses[[edge.from_ for edge in edges]], poses[[edge.to for edge in edges]]
    away = between(np.array([edge.pose for edge in edges]), between(first, last))
    return np.hypot(away[:, 0], away[:, 1]), np.degrees(np.abs(away[:, 2]))
