"""From lidar scans to a map of surfaces, in stages: dead reckoning, loops, the graph, what has moved."""

import time
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Protocol

import msgspec
import numpy as np

from contract.geometry import Array
from contract.point_map.tiles import Surfels
from contract.roads.model import Origin
from vehicle_agent.localization.odometry.motion import inverted
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.cloud_mapping.gnss_fixes import Fixes, FixParams, laid_on, places_of
from workshop.cloud_mapping.ground import GroundParams, ground_of
from workshop.cloud_mapping.keyframes import KeyframeParams, Reckoned, reckoned, scan_poses
from workshop.cloud_mapping.loops import LoopCloser, LoopParams
from workshop.cloud_mapping.pose_graph import (
    Edge,
    GraphParams,
    Ground,
    Optimized,
    Place,
    information_of,
    optimized,
)
from workshop.cloud_mapping.residuals import Residuals, residuals
from workshop.cloud_mapping.solution import Solved
from workshop.cloud_mapping.surfaces import SurfaceParams, surfels_of


class CloudMappingParams(msgspec.Struct, frozen=True):
    """The parameters of the stages, and which are left out.

    step_std_m, step_std_rad  of dead reckoning from one keyframe to the next
    near_m                    of the rounds of loops by nearness, one after the other
    lever_sensor_m            where the place of the fixes is, in the lidar's frame
    """

    keyframes: KeyframeParams = KeyframeParams()
    ground: GroundParams = GroundParams()
    loops: LoopParams = LoopParams()
    fixes: FixParams = FixParams()
    graph: GraphParams = GraphParams()
    surfaces: SurfaceParams = SurfaceParams()
    step_std_m: float = 0.01
    step_std_rad: float = 0.0007
    near_m: tuple[float, ...] = (15.0, 8.0)
    lever_sensor_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    with_loops: bool = True
    with_ground: bool = True


class MappingProgress(Protocol):
    """What is told how far the work is."""

    def begin(self, stage: str, steps: int) -> None: ...
    def advance(self, steps: int) -> None: ...


class NoProgress:
    """Tells nothing."""

    def begin(self, stage: str, steps: int) -> None:
        pass

    def advance(self, steps: int) -> None:
        pass


class TooFewScans(Exception):
    """There is nothing to make a map of; the message is one sentence."""


class CloudMap(msgspec.Struct, frozen=True):
    """What a drive became.

    surfels    map frame; removed: elements that had moved
    stamps_ns  (n,), poses (n, 4, 4) T_map_sensor of all scans
    keyframe_poses (k, 4, 4); loops: edges that are believed at last
    origin     of the map frame; None: it is the first scan's sensor
    """

    surfels: Surfels
    stamps_ns: np.ndarray
    poses: Array
    keyframe_poses: Array
    loops: tuple[Edge, ...]
    origin: Origin | None
    residuals: Residuals
    notes: tuple[str, ...]


class Drive(msgspec.Struct, frozen=True):
    """Dead reckoning and the ground below it: what the stages after it begin with."""

    reckoned: Reckoned
    ground: Ground


def reckoned_drive(
    scans: Iterable[PointCloud], expected: int, params: CloudMappingParams, progress: MappingProgress
) -> Drive:
    """The first stage. Raises TooFewScans."""
    progress.begin("odometry", expected)
    drive = reckoned(scans, params.keyframes, progress.advance)
    if len(drive.poses) < 2 or not any(len(cloud) for cloud in drive.clouds):
        raise TooFewScans(
            f"{len(drive.stamps_ns)} scans, of which {drive.scans_empty} show too little, make no map."
        )
    return Drive(drive, ground_of(drive.clouds, params.ground))


def solved(
    drive: Drive, fixes: Fixes | None, params: CloudMappingParams, progress: MappingProgress
) -> Solved:
    """The keyframes' poses from dead reckoning, ground, fixes and loops."""
    return solved_on(drive, places_on(drive.reckoned, fixes, params), (0,), params, progress)


def solved_on(
    drive: Drive, places: Sequence[Place], starts: Sequence[int], params: CloudMappingParams,
    progress: MappingProgress,
) -> Solved:  # fmt: skip
    """The same for places that are known. starts: the first keyframe of each drive that `drive` joins."""
    poses = np.array(drive.reckoned.poses)
    ground = drive.ground if params.with_ground else None
    steps = _steps(poses, starts, params)
    clock = _CpuClock()
    start = laid_on(poses, list(places)) if places else poses
    graph = clock.timed(partial(optimized, start, steps, places, ground, params.graph))
    loops: list[Edge] = []
    tried = 0
    if params.with_loops:
        closer = LoopCloser(drive.reckoned.clouds, poses, drive.ground, params.loops, starts)
        progress.begin("loops by looks", len(closer.compared))
        loops = closer.by_looks(graph.poses if places else None, progress.advance)
        for near_m in params.near_m:
            graph = clock.timed(
                partial(optimized, graph.poses, [*steps, *loops], places, ground, params.graph)
            )
            progress.begin(f"loops within {near_m:.0f} m", len(closer.compared))
            loops = _merged(loops, closer.by_nearness(graph.poses, near_m, progress.advance))
        graph = clock.timed(partial(optimized, graph.poses, [*steps, *loops], places, ground, params.graph))
        tried = closer.tried
    return Solved(graph, (*steps, *loops), tuple(places), tried, clock.total_s)


def map_scans(
    scans: Iterable[PointCloud], expected: int, fixes: Fixes | None, params: CloudMappingParams,
    progress: MappingProgress,
) -> CloudMap:  # fmt: skip
    """The map and the drive through it. Equal scans give equal maps. Raises TooFewScans."""
    return finished(reckoned_drive(scans, expected, params, progress), fixes, params, progress)


def finished(
    drive: Drive, fixes: Fixes | None, params: CloudMappingParams, progress: MappingProgress
) -> CloudMap:
    """The stages after dead reckoning."""
    solution = solved(drive, fixes, params, progress)
    origin = fixes.origin if fixes is not None and solution.places else None
    found = cloud_map_of(drive, solution, origin, params, progress)
    return msgspec.structs.replace(found, notes=_notes(found.residuals, fixes, params))


def cloud_map_of(
    drive: Drive, solution: Solved, origin: Origin | None, params: CloudMappingParams,
    progress: MappingProgress,
) -> CloudMap:  # fmt: skip
    """The surfaces that are seen from solved poses; without notes."""
    graph, clouds = solution.graph, drive.reckoned.clouds
    progress.begin("surfaces", 2 * len(clouds))
    surfels, removed = surfels_of(clouds, graph.poses, params.surfaces, progress.advance)
    loops = tuple(
        edge for edge, weight in zip(solution.edges, graph.edge_weights, strict=True)
        if edge.is_loop and weight > 0.25
    )  # fmt: skip
    numbers = residuals(drive.reckoned, solution, len(surfels), removed)
    return CloudMap(
        surfels,
        np.array(drive.reckoned.stamps_ns, dtype=np.int64),
        scan_poses(drive.reckoned, graph.poses),
        graph.poses,
        loops,
        origin,
        numbers,
        (),
    )


def _notes(numbers: Residuals, fixes: Fixes | None, params: CloudMappingParams) -> tuple[str, ...]:
    found = []
    if params.with_loops and numbers.loops_closed == 0:
        found.append("No loop was found: the map drifts as the odometry does, but for what GNSS holds.")
    if fixes is not None and numbers.fixes_used == 0:
        found.append("No fix belongs to a scan: compare their stamps. The map begins at its first scan.")
    if fixes is not None and fixes.dropped:
        found.append(f"{fixes.dropped} fixes without a solution, or not finite, were left out.")
    if numbers.scans_empty:
        found.append(f"{numbers.scans_empty} scans have too few points; their poses are predicted.")
    if numbers.stamps_back:
        found.append(f"{numbers.stamps_back} scans have a stamp that does not rise.")
    return tuple(found)


def _steps(poses: Array, starts: Sequence[int], params: CloudMappingParams) -> list[Edge]:
    """From each keyframe to the next one of the same drive."""
    found = []
    for number in range(len(poses) - 1):
        if number + 1 in starts:
            continue
        step = inverted(poses[number]) @ poses[number + 1]
        grown = max(1.0, float(np.linalg.norm(step[:3, 3])))
        information = information_of(params.step_std_m * grown, params.step_std_rad * grown)
        found.append(Edge(number, number + 1, step, information, False))
    return found


def places_on(drive: Reckoned, fixes: Fixes | None, params: CloudMappingParams) -> list[Place]:
    """The fixes as places of the drive's keyframes; none if they give no heading."""
    if fixes is None:
        return []
    poses = np.array(drive.poses)
    way_m = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1))))
    stamps_ns = np.array(drive.stamps_ns, dtype=np.int64)[drive.keyframes]
    places = places_of(fixes, stamps_ns, way_m, np.array(params.lever_sensor_m), params.fixes)
    # Two places of one drive give a heading; fewer would leave the map free to turn.
    return places if len(places) >= 2 else []


def _merged(older: Sequence[Edge], newer: Sequence[Edge]) -> list[Edge]:
    """All pairs once; the newer registration of a pair began nearer to the truth."""
    pairs = {(edge.from_, edge.to): edge for edge in (*older, *newer)}
    return list(pairs.values())


class _CpuClock:
    """Adds up the CPU time of what it is given. The time is reported and decides nothing."""

    def __init__(self) -> None:
        self.total_s = 0.0

    def timed(self, work: Callable[[], Optimized]) -> Optimized:
        begun_s = time.process_time()
        found = work()
        self.total_s += time.process_time() - begun_s
        return found
