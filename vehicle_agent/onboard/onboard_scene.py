"""What a vehicle sees and plans, in detail: for the run log at 5 Hz, and for an operator who asks for it."""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from contract.geometry import Pose2
from contract.wire.messages import (
    Command,
    CommandDone,
    LimitAhead,
    OnboardScene,
    PathTimes,
    PathTrack,
    TickTimes,
    TracksBy,
)
from vehicle_agent.onboard.seen_things import (
    SCAN_NS_MAX,
    PlacedScan,
    age_s,
    nearest_cells,
    placed_scan,
    shown_scan,
    shown_signs,
    shown_tracks,
)
from vehicle_agent.signals import UNBOUNDED_CM, Flow, InboxItem, Outputs, PathGraph, PlanAnswer, ThinnedScan

# An operator's request holds for so long; then it is asked again.
SHOWN_NS = 60_000_000_000
# 2.5 Hz: with at most 16 kB a scene, 40 kB/s while it is shown.
SHOW_EVERY_TICKS = 20
# Scans are placed by the poses of the last second.
POSES_KEPT = 50


class SceneSource:
    """Sees every tick; makes scenes, and knows whether an operator looks.

    new_scan  the thinned scan that came in the last tick, if any
    """

    def __init__(self, tracks_by: TracksBy = "") -> None:
        """tracks_by: who finds the vehicle's road users."""
        self.new_scan: PlacedScan | None = None
        self._tracks_by: TracksBy = tracks_by
        self._scan: PlacedScan | None = None
        self._poses: deque[tuple[int, Pose2]] = deque(maxlen=POSES_KEPT)
        self._answer: PlanAnswer | None = None
        self._shown_until_ns = 0
        self._ticks = 0

    def observe(self, items: Sequence[InboxItem], outputs: Outputs, stamp_ns: int) -> None:
        self._ticks += 1
        pose_map = outputs.flow.ego.pose_map
        if math.isfinite(pose_map.x_m + pose_map.y_m + pose_map.yaw_rad):
            self._poses.append((stamp_ns, pose_map))
        self.new_scan = None
        for item in items:
            if isinstance(item.body, PlanAnswer):
                self._answer = item.body
            elif isinstance(item.body, ThinnedScan):
                self.new_scan = placed_scan(item.body, tuple(self._poses))
        self._scan = self.new_scan or self._scan
        if _is_asked_for(items, outputs):
            self._shown_until_ns = stamp_ns + SHOWN_NS

    def is_due(self, stamp_ns: int) -> bool:
        """An operator looks, and the next scene is to be sent."""
        return stamp_ns < self._shown_until_ns and self._ticks % SHOW_EVERY_TICKS == 0

    def scene(
        self, flow: Flow, stamp_ns: int, tick_times: TickTimes | None, with_points: bool
    ) -> OnboardScene:
        """with_points: cells and scan too, which a run log has already (`/perception/...`)."""
        detections, pose_map, scan = flow.detections, flow.ego.pose_map, self._scan
        shows_scan = with_points and scan is not None and stamp_ns - scan.stamp_ns < SCAN_NS_MAX
        has_scan = with_points and detections.stamp_ns > 0
        return OnboardScene(
            epoch=0,
            stamp_ns=stamp_ns,
            points=nearest_cells(flow) if has_scan else (),
            points_age_s=age_s(stamp_ns, detections.stamp_ns) if has_scan else 0.0,
            limited_by=flow.path.limited_by,
            speed_mps_planned=round(flow.path.speed_mps, 2),
            guard=flow.guard_status.intervened,
            path_times=self._path_times(flow, stamp_ns),
            tick_times=tick_times,
            tracks_by=self._tracks_by,
            tracks=shown_tracks(detections.tracks, pose_map, frozenset(flow.path.yields_to)),
            tracks_age_s=age_s(stamp_ns, detections.tracks.stamp_ns) if detections.tracks.stamp_ns else 0.0,
            signs=shown_signs(detections.signs, pose_map),
            scan=shown_scan(scan, stamp_ns) if shows_scan and scan is not None else None,
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


def _metres(ways_cm: np.ndarray) -> tuple[float, ...]:
    return tuple((ways_cm.astype(np.int64) / 100.0).tolist())


def _bounds(ways_cm: np.ndarray) -> tuple[float | None, ...]:
    return tuple(
        None if abs(way_cm) >= UNBOUNDED_CM else max(way_cm, 0) / 100.0 for way_cm in ways_cm.tolist()
    )
