"""Refinement: keyframes that lie near each other after loop closure are matched once more, one by one."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
from scipy.spatial import cKDTree

from contract.geometry import Array
from vehicle_agent.localization.laser.point_index import index_points
from vehicle_agent.localization.laser.point_to_line import MatchParams, match_to_lines
from vehicle_agent.localization.laser.pose_arrays import between
from workshop.laser_mapping.keyframes import Keyframes
from workshop.laser_mapping.pose_graph import Edge, GraphParams, NodePlace, Optimized, optimized
from workshop.laser_mapping.submaps import joined_surface


class RefinementParams(msgspec.Struct, frozen=True):
    """Which keyframes are matched to which.

    near_m         farthest apart
    passes_max     each keyframe is matched to at most so many other passes of the place
    pass_keyframes keyframes on either side of the nearest one of a pass that are matched to together
    apart          fewer keyframes between two than this belong to one pass
    correction_m   a match that moves the keyframe farther is not believed, nor one that turns it more
    prior_m, prior_rad  standard deviation of a keyframe's pose relative to another pass
    """

    near_m: float = 6.0
    passes_max: int = 6
    pass_keyframes: int = 4
    apart: int = 8
    inlier_ratio_min: float = 0.4
    correction_m: float = 0.5
    correction_rad: float = 0.1
    prior_m: float = 0.2
    prior_rad: float = 0.05
    matches: tuple[MatchParams, ...] = (
        MatchParams(distance_m_first=0.5, residual_m=0.06),
        MatchParams(distance_m_first=0.25, residual_m=0.05),
        MatchParams(distance_m_first=0.2, residual_m=0.04),
    )
    graph: GraphParams = GraphParams()


class Refined(msgspec.Struct, frozen=True):
    """The last round: its graph, and the edges that it consists of."""

    graph: Optimized
    edges: tuple[Edge, ...]


def refined(
    keyframes: Keyframes,
    poses: Array,
    loops: tuple[Edge, ...],
    params: RefinementParams,
    advance: Callable[[int], None],
    places: tuple[NodePlace, ...] = (),
) -> Refined:
    """The keyframes' poses from the edges of dead reckoning, of loops and of all passes of each place.

    places  of keyframes in the map frame, where a receiver said them
    """
    graph = Optimized(poses, np.zeros(0), np.zeros(0), 0)
    edges: tuple[Edge, ...] = ()
    for match in params.matches:
        edges = (*keyframes.edges, *_pass_edges(keyframes, graph.poses, match, params, advance))
        # A loop that no keyframe confirms still holds the map together.
        edges = (*edges, *loops)
        graph = optimized(graph.poses, edges, params.graph, places)
    return Refined(graph, edges)


def _pass_edges(
    keyframes: Keyframes,
    poses: Array,
    match: MatchParams,
    params: RefinementParams,
    advance: Callable[[int], None],
) -> list[Edge]:
    tree = cKDTree(poses[:, :2])
    prior = np.diag([params.prior_m**-2, params.prior_m**-2, params.prior_rad**-2])
    edges = []
    for number in range(len(keyframes)):
        for other in _other_passes(number, tree, poses, params):
            first = max(0, other - params.pass_keyframes)
            last = min(len(keyframes), other + params.pass_keyframes + 1)
            anchor = poses[other]
            reference = joined_surface(poses[first:last], keyframes.surfaces[first:last], anchor)
            index = index_points(reference.points_laser, reference.normals_laser, match.distance_m_first)
            start = between(anchor, poses[number])
            found = match_to_lines(keyframes.surfaces[number], index, start, prior, match)
            moved = found.pose - start
            if (
                found.inlier_ratio >= params.inlier_ratio_min
                and math.hypot(moved[0], moved[1]) <= params.correction_m
                and abs(math.remainder(moved[2], math.tau)) <= params.correction_rad
            ):
                edges.append(Edge(other, number, found.pose, found.information, True))
        advance(1)
    return edges


def _other_passes(number: int, tree: cKDTree, poses: Array, params: RefinementParams) -> list[int]:
    """The nearest keyframe of each older pass of this place, the nearest passes first."""
    near = sorted(
        i for i in tree.query_ball_point(poses[number, :2], params.near_m) if i <= number - params.apart
    )
    distances = np.hypot(poses[near, 0] - poses[number, 0], poses[near, 1] - poses[number, 1])
    nearest: list[tuple[float, int]] = []
    last = -params.apart
    for distance_m, other in zip(distances, near, strict=True):
        if other - last < params.apart // 2 and nearest:
            nearest[-1] = min(nearest[-1], (float(distance_m), other))
        else:
            nearest.append((float(distance_m), other))
        last = other
    return [other for _, other in sorted(nearest)[: params.passes_max]]
