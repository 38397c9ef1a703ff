"""Plan jobs on a straight line, with defaults."""

import numpy as np

from contract.geometry import Pose2
from contract.roads.areas import AreaAhead
from contract.roads.model import SCENARIOS, Scenario
from tests.vehicle_agent.world.builders import some_tracks
from vehicle_agent.planning.behaviour.crossing_traffic import CrossingRules
from vehicle_agent.planning.behaviour.decide import BehaviourRules
from vehicle_agent.signals import (
    NO_VIEW,
    Corridor,
    PlanJob,
    PlanMemory,
    Predictions,
    Tracks,
    View,
    WatchedArea,
)
from vehicle_agent.world.prediction import straight_on

FRONT_M = 3.5
RULES = BehaviourRules(front_m=FRONT_M, back_m=0.85, half_width_m=0.815, crossing=CrossingRules(FRONT_M))


def a_corridor(scenario: Scenario = "common_road", half_m: float = 2.5) -> Corridor:
    """From 8 m behind to 60 m ahead of x = 20."""
    s = np.arange(12.0, 80.5, 0.5)
    n = len(s)
    return Corridor(
        s,
        np.column_stack((s, np.zeros(n))),
        np.zeros(n),
        np.zeros(n),
        np.full(n, 4.2),
        np.full(n, half_m),
        np.full(n, half_m),
        np.full(n, SCENARIOS.index(scenario), np.int64),
    )


def a_job(
    tracks: Tracks | None = None,
    *,
    points: tuple[tuple[float, float], ...] = (),
    speed_mps: float = 3.0,
    stop_s_m: float = 200.0,
    areas: tuple[AreaAhead, ...] = (),
    watched: tuple[WatchedArea, ...] = (),
    memory: PlanMemory | None = None,
    view: View = NO_VIEW,
    scenario: Scenario = "common_road",
) -> PlanJob:
    """The rear axle at x = 20, heading along the line."""
    tracks = tracks if tracks is not None else some_tracks()
    times_s = np.arange(37) * 0.25
    poses = straight_on(tracks.poses_map, tracks.velocities_map_mps, times_s)
    sigmas = np.tile(0.1 + 0.2 * times_s, (len(tracks.ids), 1))
    return PlanJob(
        number=1,
        stamp_ns=1,
        line_id=1,
        pose_map=Pose2(20.0, 0.0, 0.0),
        speed_mps=speed_mps,
        accel_mps2=0.0,
        curvature_1pm=0.0,
        corridor=a_corridor(scenario),
        stop_s_m=stop_s_m,
        stop_reason="stop",
        speed_mps_max=4.2,
        speed_reason="speed_limit",
        points_map=np.array(points, dtype=np.float64).reshape(-1, 2),
        tracks=tracks,
        predictions=Predictions(1, times_s, poses, sigmas),
        view=view,
        watched=watched,
        areas=areas,
        memory=memory or PlanMemory(),
    )
