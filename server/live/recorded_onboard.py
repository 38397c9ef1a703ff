"""What a vehicle saw and planned in a part of a run, in the shape in which it sends it live."""

import math
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from contract.runlog.foxglove import points_of, scan_of
from contract.runlog.indexed import messages_of
from contract.runlog.reader import RunLogError
from contract.runlog.records import OBSTACLE_TOPIC, ONBOARD_TOPIC, POINTS_TOPIC
from contract.wire.messages import OnboardScene, ShownScan
from contract.wire.onboard_scene import SCAN_POINTS_MAX, SCENE_POINTS_MAX

MS_NS = 1_000_000
# The points of a scan are shown until the next one, and no longer than this.
CELLS_MS_MAX = 1_000
# Points come once a second.
POINTS_MS_MAX = 2_500


class OnboardMoment(msgspec.Struct, frozen=True):
    at_ms: int
    scene: OnboardScene


def recorded_onboard(segments: Sequence[Path], from_ms: int, to_ms: int) -> list[OnboardMoment]:
    """Every scene of [from_ms, to_ms) with the obstacle cells of the scan before it, oldest first.

    The points of a scan are with the first scene after it. Runs of an older agent have none. A damaged or cut
    segment ends where it is no longer sound; so does one with a message that is none of these.
    """
    found: list[OnboardMoment] = []
    cloud, cloud_ms = b"", -CELLS_MS_MAX
    scan: ShownScan | None = None
    scan_ms = 0
    topics = (ONBOARD_TOPIC, OBSTACLE_TOPIC, POINTS_TOPIC)
    begin_ms = from_ms - max(CELLS_MS_MAX, POINTS_MS_MAX)
    for path in segments:
        try:
            for message in messages_of(path, topics, begin_ms * MS_NS, to_ms * MS_NS):
                at_ms = message.log_ns // MS_NS
                if message.topic == OBSTACLE_TOPIC:
                    cloud, cloud_ms = message.data, at_ms
                elif message.topic == POINTS_TOPIC:
                    scan, scan_ms = _scan(message.data), at_ms
                elif at_ms >= from_ms:
                    is_new = at_ms - cloud_ms < CELLS_MS_MAX
                    scene = _scene(message.data, at_ms, cloud if is_new else b"", cloud_ms)
                    if scan is not None and at_ms - scan_ms < POINTS_MS_MAX:
                        shown = msgspec.structs.replace(scan, age_s=_seconds(at_ms - scan_ms))
                        scene = msgspec.structs.replace(scene, scan=shown)
                    scan = None
                    found.append(OnboardMoment(at_ms, scene))
        except (msgspec.DecodeError, ValueError):
            continue
        except RunLogError as error:
            if error.code not in ("truncated", "damaged"):
                raise
    return found


def _scene(data: bytes, at_ms: int, cloud: bytes, cloud_ms: int) -> OnboardScene:
    scene = msgspec.json.decode(data, type=OnboardScene)
    if cloud:
        points = points_of(cloud)[:SCENE_POINTS_MAX].astype(np.float64)
        points = points[np.isfinite(points).all(axis=1)].round(2)
        scene = msgspec.structs.replace(
            scene, points=tuple(points.ravel().tolist()), points_age_s=_seconds(at_ms - cloud_ms)
        )
    return scene


def _seconds(span_ms: int) -> float:
    return math.floor(max(span_ms, 0) / 10) / 100


def _scan(cloud: bytes) -> ShownScan:
    """The points along the map's axes, from the place at which they were measured."""
    pose, points = scan_of(cloud)
    points = points[np.isfinite(points).all(axis=1)][:SCAN_POINTS_MAX].astype(np.float64)
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    turned = points @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    offsets_cm = np.clip(np.rint(100.0 * turned), -32_767, 32_767).astype("<i2")
    return ShownScan(pose.x_m, pose.y_m, 0.0, offsets_cm.tobytes())
