"""What a vehicle sees, as an operator's screen gets it: obstacle cells, road users, signs, points."""

import math

import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.wire.messages import ShownScan, ShownSign, ShownTrack
from vehicle_agent.signals import TRACK_KINDS, Flow, SeenSign, ThinnedScan, Tracks
from vehicle_agent.signals.pose_history import PoseHistory, pose_at

NEAR_M = 40.0
# What is shown live: with the graph of a busy crossing, 16 kB of JSON.
CELLS_MAX = 300
TRACKS_MAX = 30
SIGNS_MAX = 12
SCAN_POINTS_SHOWN = 400
# A scan comes once a second.
SCAN_NS_MAX = 2_500_000_000


class PlacedScan(msgspec.Struct, frozen=True):
    """Points of a scan, and where the vehicle was at its end; points_base (n, 3)."""

    stamp_ns: int
    pose_map: Pose2
    points_base: np.ndarray


def placed_scan(scan: ThinnedScan, poses: PoseHistory) -> PlacedScan | None:
    """None while the vehicle does not know where it is."""
    if not poses:
        return None
    whole = scan.points_cm[: len(scan.points_cm) // 6 * 6]
    points_base = 0.01 * np.frombuffer(whole, dtype="<i2").reshape(-1, 3)
    return PlacedScan(scan.stamp_ns, pose_at(poses, scan.stamp_ns), points_base)


def shown_scan(scan: PlacedScan, stamp_ns: int) -> ShownScan:
    """At most SCAN_POINTS_SHOWN points, spread over the scan."""
    points = scan.points_base[:: max(1, -(-len(scan.points_base) // SCAN_POINTS_SHOWN))]
    cos, sin = math.cos(scan.pose_map.yaw_rad), math.sin(scan.pose_map.yaw_rad)
    offsets_m = np.column_stack(
        (cos * points[:, 0] - sin * points[:, 1], sin * points[:, 0] + cos * points[:, 1], points[:, 2])
    )
    offsets_cm = np.clip(np.rint(100.0 * offsets_m), -32_767, 32_767).astype("<i2")
    x_m, y_m = round(scan.pose_map.x_m, 2), round(scan.pose_map.y_m, 2)
    return ShownScan(x_m, y_m, age_s(stamp_ns, scan.stamp_ns), offsets_cm.tobytes())


def nearest_cells(flow: Flow) -> tuple[float, ...]:
    """x0, y0, x1, y1, ... of the nearest obstacle cells within NEAR_M."""
    points, pose = flow.detections.points_map, flow.ego.pose_map
    nearest = _nearest(points, pose, CELLS_MAX)
    return tuple(points[nearest].round(2).ravel().tolist())


def shown_tracks(tracks: Tracks, pose_map: Pose2, yields_to: frozenset[int]) -> tuple[ShownTrack, ...]:
    """The nearest within NEAR_M that sensors see; fleet vehicles known by message alone are left out."""
    shown = []
    for i in _nearest(tracks.poses_map, pose_map, TRACKS_MAX):
        numbers = (*tracks.poses_map[i], *tracks.sizes_m[i], *tracks.velocities_map_mps[i])
        x_m, y_m, yaw_rad, length_m, width_m, vx_mps, vy_mps = (round(float(one), 2) for one in numbers)
        track_id = int(tracks.ids[i])
        kind = TRACK_KINDS[tracks.kinds[i]]
        yielded_to = track_id in yields_to
        shown.append(
            ShownTrack(track_id, kind, x_m, y_m, yaw_rad, length_m, width_m, vx_mps, vy_mps, yielded_to)
        )
    return tuple(shown)


def shown_signs(signs: tuple[SeenSign, ...], pose_map: Pose2) -> tuple[ShownSign, ...]:
    """The nearest, whatever their kind."""
    if not math.isfinite(pose_map.x_m + pose_map.y_m):
        return ()
    shown = []
    for sign in signs:
        place = sign.pose_map
        x_m, y_m, yaw_rad = round(place.x_m, 2), round(place.y_m, 2), round(place.yaw_rad, 2)
        distance_m = math.hypot(place.x_m - pose_map.x_m, place.y_m - pose_map.y_m)
        shown.append(ShownSign(sign.sign_id, sign.kind, x_m, y_m, yaw_rad, round(distance_m, 1)))
    return tuple(sorted(shown, key=lambda one: one.distance_m)[:SIGNS_MAX])


def age_s(now_ns: int, then_ns: int) -> float:
    return round(max(now_ns - then_ns, 0) * 1e-9, 2)


def _nearest(places: np.ndarray, pose_map: Pose2, count: int) -> np.ndarray:
    """Rows of places (n, 2 or more) by distance; none while the vehicle has no finite place."""
    if not len(places) or not math.isfinite(pose_map.x_m + pose_map.y_m):
        return np.empty(0, np.int64)
    distances_m = np.hypot(places[:, 0] - pose_map.x_m, places[:, 1] - pose_map.y_m)
    nearest = np.argsort(distances_m, kind="stable")[:count]
    kept: np.ndarray = nearest[distances_m[nearest] <= NEAR_M]
    return kept
