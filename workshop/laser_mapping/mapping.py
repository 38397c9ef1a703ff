"""From a laser log to an occupancy map, in four stages: dead reckoning, loop closure, refinement, the map."""

from typing import Protocol

import msgspec
import numpy as np

from contract.geometry import Array
from contract.occupancy.occupancy_map import OccupancyMap
from vehicle_agent.localization.laser.dead_reckoning import DeadReckoningParams
from workshop.carmen.laser_logs import LaserLog
from workshop.laser_mapping.keyframes import dead_reckoned, scan_poses
from workshop.laser_mapping.loops import LoopParams, LoopSearch
from workshop.laser_mapping.occupancy import OccupancyParams, occupancy_map
from workshop.laser_mapping.pose_graph import Edge
from workshop.laser_mapping.refinement import RefinementParams, refined
from workshop.laser_mapping.residuals import Residuals, residuals


class MappingParams(msgspec.Struct, frozen=True):
    """The parameters of the stages."""

    dead_reckoning: DeadReckoningParams = DeadReckoningParams()
    loops: LoopParams = LoopParams()
    refinement: RefinementParams = RefinementParams()
    occupancy: OccupancyParams = OccupancyParams()


class MappingProgress(Protocol):
    """Who is told how far the work is."""

    def begin(self, stage: str, steps: int) -> None: ...
    def advance(self, steps: int) -> None: ...


class NoProgress:
    """Nobody is told."""

    def begin(self, stage: str, steps: int) -> None:
        pass

    def advance(self, steps: int) -> None:
        pass


class LaserMap(msgspec.Struct, frozen=True):
    """What a log became.

    poses           (n, 3) of the laser in the map frame, one for each scan; the first is the origin
    keyframe_poses  (k, 3) those that the graph has
    loops           edges between keyframes where the laser came back to a place
    """

    occupancy: OccupancyMap
    stamps_s: Array
    poses: Array
    keyframe_poses: Array
    loops: tuple[Edge, ...]
    residuals: Residuals


def map_log(log: LaserLog, params: MappingParams, progress: MappingProgress) -> LaserMap:
    """The map and the drive through it. Equal logs give equal maps. Raises MapTooLarge."""
    progress.begin("dead reckoning", len(log))
    reckoned = dead_reckoned(log, params.dead_reckoning, progress.advance)
    keyframes = reckoned.keyframes
    search = LoopSearch(keyframes, params.loops)
    progress.begin("loop closure", search.steps)
    loops = search.run(progress.advance)
    progress.begin("refinement", len(keyframes) * len(params.refinement.matches))
    graph = refined(keyframes, loops.poses, loops.edges, params.refinement, progress.advance)
    poses = scan_poses(reckoned, graph.graph.poses)
    progress.begin("occupancy", len(log))
    occupancy = occupancy_map(log, poses, params.occupancy, progress.advance)
    return LaserMap(
        occupancy,
        log.stamps_s,
        poses,
        graph.graph.poses,
        loops.edges,
        residuals(reckoned, loops, graph, _length_m(poses)),
    )


def _length_m(poses: Array) -> float:
    steps = np.diff(poses[:, :2], axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
