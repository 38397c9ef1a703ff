"""Our motion planner under the open planners' own conditions: exact poses, plans followed exactly."""

import time

import numpy as np

from benchmarks.peers.messages import OTHER_COLUMNS, Plan, PlanRequest, Road
from campusloop.scenes.drive import Scene
from campusloop.scenes.path_map import LANE_ID
from contract.geometry import Array, Pose2, project
from contract.roads.network import RoadNetwork
from contract.roads.routing import Route, route_line
from vehicle_agent.planning.motion.corridor import corridor_of, window
from vehicle_agent.signals import NO_VIEW, PEDESTRIAN, VEHICLE, PlanJob, PlanMemory, Tracks
from vehicle_agent.stacks.choice import build_planner
from vehicle_agent.world.prediction import Predictor

# As `MotionPlanning` cuts it out for a job.
_BEHIND_M, _AHEAD_M = 8.0, 55.0


class OurPlanner:
    """A `benchmarks.peers.drive.Driver`. The view is open in every direction, as the others take it to be."""

    def __init__(self, scene: Scene) -> None:
        self._network = RoadNetwork(scene.road_map)
        length_m = self._network.lines[LANE_ID].length_m
        line = route_line(self._network, Route((LANE_ID,), 0.0, length_m, length_m, 0.0))
        self._points, self._s = line.points, line.s
        self._corridor = corridor_of(line, self._network)
        self._end_m = length_m - 0.5
        self._cap_mps = scene.profile.limits.speed_mps_max
        self._segment = int(np.searchsorted(self._s, scene.start_s_m))
        self._predictor = Predictor()
        planner = build_planner(scene.profile, scene.road_map)
        assert planner is not None, "a stack with a planner"
        self._planner = planner
        self._memory = PlanMemory()
        self._jobs = 0

    def begin(self, road: Road) -> None:
        """The road is the scene's, which it has."""

    def plan(self, request: PlanRequest) -> Plan:
        self._jobs += 1
        s_m, _, self._segment = project(
            self._points, self._s, request.x_m, request.y_m, self._segment - 3, self._segment + 6
        )
        tracks = tracks_of(request)
        job = PlanJob(
            number=self._jobs,
            stamp_ns=tracks.stamp_ns,
            line_id=1,
            pose_map=Pose2(request.x_m, request.y_m, request.yaw_rad),
            speed_mps=request.v_mps,
            accel_mps2=request.a_mps2,
            curvature_1pm=request.curvature_1pm,
            corridor=window(self._corridor, float(s_m), _BEHIND_M, _AHEAD_M),
            stop_s_m=self._end_m,
            stop_reason="stop",
            speed_mps_max=self._cap_mps,
            speed_reason="speed_limit",
            points_map=np.empty((0, 2)),
            tracks=tracks,
            predictions=self._predictor.predictions(tracks, self._network),
            view=NO_VIEW,
            watched=(),
            areas=(),
            memory=self._memory,
        )
        begun_cpu, begun_wall = time.process_time_ns(), time.perf_counter_ns()
        answer = self._planner(job)
        cpu_ms = 1e-6 * (time.process_time_ns() - begun_cpu)
        wall_ms = 1e-6 * (time.perf_counter_ns() - begun_wall)
        self._memory = answer.memory
        rows: Array = (
            answer.trajectory[:, (0, 1, 2, 3, 5, 6, 4)] if len(answer.trajectory) else np.empty((0, 7))
        )
        return Plan([tuple(row) for row in rows.tolist()], answer.limited_by, cpu_ms, wall_ms, 0.0)


def tracks_of(request: PlanRequest) -> Tracks:
    """The others of a request as tracks of its moment."""
    others = np.array(request.others, dtype=np.float64).reshape(-1, len(OTHER_COLUMNS))
    return Tracks(
        max(1, round(1e9 * request.t_s)),
        others[:, 0].astype(np.int64),
        np.where(others[:, 8] > 0.5, PEDESTRIAN, VEHICLE).astype(np.int64),
        np.ascontiguousarray(others[:, 1:4]),
        np.ascontiguousarray(others[:, 4:6]),
        np.ascontiguousarray(others[:, 6:8]),
    )
