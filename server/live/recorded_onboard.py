"""What a vehicle saw and planned in a part of a run, in the shape in which it sends it live."""

import math
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from contract.runlog.foxglove import points_of
from contract.runlog.indexed import messages_of
from contract.runlog.reader import RunLogError
from contract.runlog.records import OBSTACLE_TOPIC, ONBOARD_TOPIC
from contract.wire.messages import OnboardScene
from contract.wire.onboard_scene import SCENE_POINTS_MAX

MS_NS = 1_000_000
# The points of a scan are shown until the next one, and no longer than this.
SCAN_MS_MAX = 1_000


class OnboardMoment(msgspec.Struct, frozen=True):
    at_ms: int
    scene: OnboardScene


def recorded_onboard(segments: Sequence[Path], from_ms: int, to_ms: int) -> list[OnboardMoment]:
    """Every scene of [from_ms, to_ms) with the obstacle cells of the scan before it, oldest first.

    Runs of an older agent have none. A damaged or cut segment ends where it is no longer sound.
    """
    found: list[OnboardMoment] = []
    cloud, cloud_ms = b"", -SCAN_MS_MAX
    topics = (ONBOARD_TOPIC, OBSTACLE_TOPIC)
    for path in segments:
        try:
            for message in messages_of(path, topics, (from_ms - SCAN_MS_MAX) * MS_NS, to_ms * MS_NS):
                at_ms = message.log_ns // MS_NS
                if message.topic == OBSTACLE_TOPIC:
                    cloud, cloud_ms = message.data, at_ms
                elif at_ms >= from_ms:
                    is_new = at_ms - cloud_ms < SCAN_MS_MAX
                    found.append(_moment(message.data, at_ms, cloud if is_new else b"", cloud_ms))
        except RunLogError as error:
            if error.code not in ("truncated", "damaged"):
                raise
    return found


def _moment(data: bytes, at_ms: int, cloud: bytes, cloud_ms: int) -> OnboardMoment:
    scene = msgspec.json.decode(data, type=OnboardScene)
    if cloud:
        points = points_of(cloud)[:SCENE_POINTS_MAX].astype(np.float64)
        points = points[np.isfinite(points).all(axis=1)].round(2)
        scene = msgspec.structs.replace(
            scene, points=tuple(points.ravel().tolist()), points_age_s=_seconds(at_ms - cloud_ms)
        )
    return OnboardMoment(at_ms, scene)


def _seconds(span_ms: int) -> float:
    return math.floor(max(span_ms, 0) / 10) / 100
