"""What a vehicle sees and plans, in detail: for the run log at 5 Hz, and for an operator who asks for it."""

import math
from collections.abc import Sequence

import numpy as np

from contract.wire.messages import (
    Command,
    CommandDone,
    LimitAhead,
    OnboardScene,
    PathTimes,
    PathTrack,
    TickTimes,
)
from contract.wire.onboard_scene import SCENE_POINTS_MAX
from vehicle_agent.signals import UNBOUNDED_CM, Flow, InboxItem, Outputs, PathGraph, PlanAnswer

# An operator's request holds for so long; then it is asked again.
SHOWN_NS = 60_000_000_000
# 2.5 Hz: with at most 15 kB a scene, 38 kB/s while it is shown.
SHOW_EVERY_TICKS = 20
NEAR_M = 40.0


class SceneSource:
    """Sees every tick; makes scenes, and knows whether an operator looks."""

    def __init__(self) -> None:
        self._answer: PlanAnswer | None = None
        self._shown_until_ns = 0
        self._ticks = 0

    def observe(self, items: Sequence[InboxItem], outputs: Outputs, stamp_ns: int) -> None:
        self._ticks += 1
        for item in items:
            if isinstance(item.body, PlanAnswer):
                self._answer = item.body
        if _is_asked_for(items, outputs):
            self._shown_until_ns = stamp_ns + SHOWN_NS

    def is_due(self, stamp_ns: int) -> bool:
        """An operator looks, and the next scene is to be sent."""
        return stamp_ns < self._shown_until_ns and self._ticks % SHOW_EVERY_TICKS == 0

    def scene(
        self, flow: Flow, stamp_ns: int, tick_times: TickTimes | None, with_points: bool
    ) -> OnboardScene:
        """with_points: the obstacle cells too, which a run log has already (`/perception/obstacles`)."""
        detections = flow.detections
        has_scan = with_points and detections.stamp_ns > 0
        return OnboardScene(
            epoch=0,
            stamp_ns=stamp_ns,
            points=_nearest_points(flow) if has_scan else (),
            points_age_s=round(max(stamp_ns - detections.stamp_ns, 0) * 1e-9, 2) if has_scan else 0.0,
            limited_by=flow.path.limited_by,
            speed_mps_planned=round(flow.path.speed_mps, 2),
            guard=flow.guard_status.intervened,
            path_times=self._path_times(flow, stamp_ns),
            tick_times=tick_times,
        )

    def _path_times(self, flow: Flow, stamp_ns: int) -> PathTimes | None:
        """Of the plan that is driven; None while none is, and once it is over."""
        answer, driven = self._answer, flow.path.trajectory
        if answer is None or answer.graph is None or driven is None or driven.stamp_ns != answer.stamp_ns:
            return None
        yields_to = set(answer.yields_to.tolist())
        return path_times(answer.graph, (stamp_ns - answer.stamp_ns) * 1e-9, yields_to)


def path_times(graph: PathGraph, age_s: float, yields_to: set[int]) -> PathTimes:
    """The graph as it goes over the wire."""
    tracks = [
        PathTrack(
            int(track_id),
            int(track_id) in yields_to,
            tuple(knots.tolist()),
            _metres(graph.from_cm[knots, a]),
            _metres(graph.to_cm[knots, a]),
        )
        for a, track_id in enumerate(graph.ids)
        if len(knots := np.flatnonzero(graph.from_cm[:, a] <= graph.to_cm[:, a]))
    ]
    return PathTimes(
        age_s=round(age_s, 2),
        dt_s=graph.dt_s,
        way_m=_metres(graph.way_cm),
        low_m=_bounds(graph.low_cm),
        high_m=_bounds(graph.high_cm),
        tracks=tuple(tracks),
        limits=tuple(
            LimitAhead(max(one.from_m, 0.0), max(one.to_m, 0.0), one.speed_mps, one.reason)
            for one in graph.limits
        ),
    )


def _is_asked_for(items: Sequence[InboxItem], outputs: Outputs) -> bool:
    """The vehicle has executed a command to show its scene in this tick."""
    done = {event.command_id for event in outputs.events if isinstance(event, CommandDone) and event.done}
    return any(
        isinstance(item.body, Command) and item.body.kind == "show_scene" and item.body.command_id in done
        for item in items
    )


def _nearest_points(flow: Flow) -> tuple[float, ...]:
    points, pose = flow.detections.points_map, flow.ego.pose_map
    if not len(points) or not math.isfinite(pose.x_m + pose.y_m):
        return ()
    distances = np.hypot(points[:, 0] - pose.x_m, points[:, 1] - pose.y_m)
    nearest = np.argsort(distances, kind="stable")[:SCENE_POINTS_MAX]
    nearest = nearest[distances[nearest] <= NEAR_M]
    return tuple(points[nearest].round(2).ravel().tolist())


def _metres(ways_cm: np.ndarray) -> tuple[float, ...]:
    return tuple((ways_cm.astype(np.int64) / 100.0).tolist())


def _bounds(ways_cm: np.ndarray) -> tuple[float | None, ...]:
    return tuple(
        None if abs(way_cm) >= UNBOUNDED_CM else max(way_cm, 0) / 100.0 for way_cm in ways_cm.tolist()
    )
