"""How well the parts of a mapped drive agree, and how far it is from a reference trajectory."""

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.odometry.motion import inverted
from workshop.cloud_mapping.keyframes import Reckoned
from workshop.cloud_mapping.solution import Solved


class Residuals(msgspec.Struct, frozen=True):
    """Numbers of a mapped drive; docs/workshop/mapping.md says what each is good for."""

    way_m: float
    scans: int
    scans_empty: int
    scans_poor: int
    stamps_back: int
    keyframes: int
    loops_tried: int
    loops_closed: int
    loops_rejected: int
    loop_median_m: float
    loop_p95_m: float
    fixes_used: int
    fixes_rejected: int
    fix_median_m: float
    fix_p95_m: float
    correction_m: float
    surfels: int
    surfels_moved: int
    optimise_s: float


def residuals(drive: Reckoned, solution: Solved, surfels: int, moved: int) -> Residuals:
    graph, poses = solution.graph, solution.graph.poses
    is_loop = np.array([edge.is_loop for edge in solution.edges], dtype=bool)
    weights = graph.edge_weights
    closed = [edge for edge, w in zip(solution.edges, weights, strict=True) if edge.is_loop and w > 0.25]
    loop_m = [
        float(np.linalg.norm((inverted(edge.pose) @ inverted(poses[edge.from_]) @ poses[edge.to])[:3, 3]))
        for edge in closed
    ]
    fix_m = [
        float(
            np.linalg.norm((poses[p.node, :3, :3] @ p.lever_sensor + poses[p.node, :3, 3] - p.place_map)[:2])
        )
        for p, w in zip(solution.places, graph.place_weights, strict=True)
        if w > 0.25
    ]
    reckoned = np.array(drive.poses)
    first = poses[0] @ inverted(reckoned[0])
    moved_m = np.linalg.norm((first @ reckoned)[:, :3, 3] - poses[:, :3, 3], axis=1)
    way_m = float(np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).sum())
    return Residuals(
        way_m,
        len(drive.stamps_ns),
        drive.scans_empty,
        drive.scans_poor,
        drive.stamps_back,
        len(poses),
        solution.tried,
        len(closed),
        int(is_loop.sum()) - len(closed),
        *_quantiles(loop_m),
        len(fix_m),
        len(solution.places) - len(fix_m),
        *_quantiles(fix_m),
        float(moved_m.max()),
        surfels,
        moved,
        solution.optimise_s,
    )


def _quantiles(values: list[float]) -> tuple[float, float]:
    return (float(np.median(values)), float(np.percentile(values, 95))) if values else (0.0, 0.0)


def trajectory_error_m(places: Array, true: Array) -> float:
    """Root mean square distance of positions (n, 3) from the true ones, laid over each other (Umeyama 1991).

    This is the absolute trajectory error (ATE) of Sturm et al. 2012, without a scale.
    """
    centred, target = places - places.mean(axis=0), true - true.mean(axis=0)
    u, _, vt = np.linalg.svd(centred.T @ target)
    rotation = vt.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
    apart = np.linalg.norm(centred @ rotation.T - target, axis=1)
    return float(np.sqrt(np.mean(apart**2)))
