"""The driving view: planned path, tracks and areas, small enough for every status."""

import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.wire.messages import AreaReport, DrivingView, Status, TrackReport
from vehicle_agent.signals import TRACK_KINDS, Flow, Outputs, Path, World

PATH_POINTS_MAX = 30
TRACKS_MAX = 30
NEAR_M = 45.0
# A track's predicted position is reported after these times.
AHEAD_S = (1.0, 2.0, 3.0)
MOVING_MPS = 0.2


def report_with_driving_view(outputs: Outputs) -> Status:
    """The tick's status with the driving view, for ticks whose status is sent or recorded."""
    return msgspec.structs.replace(outputs.report, driving=driving_view(outputs.flow))


def driving_view(flow: Flow) -> DrivingView:
    """The driving view, rounded to centimetres; the nearest tracks within 45 m."""
    return DrivingView(
        limited_by=flow.path.limited_by,
        path=_path(flow.path),
        tracks=_tracks(flow.world, flow.ego.pose_map, frozenset(flow.path.yields_to)),
        areas=_areas(flow.world),
        turn_signal=flow.motion.turn_signal,
        headlights=flow.motion.headlights,
        horn=flow.motion.horn,
        guard=flow.guard_status.intervened,
    )


def _path(path: Path) -> tuple[float, ...]:
    points = path.points_map
    if len(points) < 2:
        return ()
    count = min(len(points), PATH_POINTS_MAX)
    return _flat(points[np.linspace(0, len(points) - 1, count).round().astype(np.int64)])


def _tracks(world: World, pose_map: Pose2, yielded_to: frozenset[int]) -> tuple[TrackReport, ...]:
    tracks, predictions = world.tracks, world.predictions
    if not len(tracks.ids):
        return ()
    distances_m = np.hypot(tracks.poses_map[:, 0] - pose_map.x_m, tracks.poses_map[:, 1] - pose_map.y_m)
    nearest = [i for i in np.argsort(distances_m, kind="stable")[:TRACKS_MAX] if distances_m[i] <= NEAR_M]
    speeds = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1])
    has_predictions = len(predictions.poses_map) == len(tracks.ids)
    times = [int(np.searchsorted(predictions.times_s, t)) for t in AHEAD_S if t <= predictions.times_s[-1]]
    reports = []
    for i in nearest:
        x_m, y_m, yaw_rad = (round(float(value), 2) for value in tracks.poses_map[i])
        length_m, width_m = (round(float(value), 2) for value in tracks.sizes_m[i])
        is_moving = has_predictions and speeds[i] > MOVING_MPS
        reports.append(
            TrackReport(
                track_id=int(tracks.ids[i]),
                kind=TRACK_KINDS[tracks.kinds[i]],
                x_m=x_m,
                y_m=y_m,
                yaw_rad=yaw_rad,
                length_m=length_m,
                width_m=width_m,
                yielded_to=int(tracks.ids[i]) in yielded_to,
                ahead=_flat(predictions.poses_map[i][times, :2]) if is_moving else (),
            )
        )
    return tuple(reports)


def _areas(world: World) -> tuple[AreaReport, ...]:
    """The areas that the stack watches and the areas that a camera reports."""
    tracked = {area.area_id: len(area.track_ids) for area in world.watched}
    cameras = {presence.area_id: presence for presence in world.presence}
    reports = []
    for area_id in sorted(tracked.keys() | cameras.keys()):
        camera = cameras.get(area_id)
        count, age_s = -1, 0.0
        if camera is not None:
            count, age_s = camera.count, round((world.stamp_ns - camera.stamp_ns) * 1e-9, 2)
        reports.append(AreaReport(area_id, tracked.get(area_id, 0), count, age_s))
    return tuple(reports)


def _flat(points: np.ndarray) -> tuple[float, ...]:
    return tuple(points.round(2).ravel().tolist())
