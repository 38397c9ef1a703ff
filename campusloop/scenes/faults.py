"""Input faults of a driven scene: values of sensors, workers and cameras that are wrong or lost."""

import math
from typing import Literal

import msgspec
import numpy as np

from contract.geometry import Array
from contract.roads.areas import inside, outline_array
from contract.roads.model import ObservationArea, Origin, RoadMap
from contract.roads.projection import project, unproject
from simulator.traffic.actors import Bodies
from vehicle_agent.signals import (
    PEDESTRIAN,
    GnssFix,
    InboxBody,
    ObstaclePercept,
    PedestrianPresence,
    TrackPercept,
)

FaultKind = Literal[
    "pose_nan", "pose_jump", "pose_lost", "tracks_empty", "tracks_absurd", "tracks_lost", "scans_lost",
    "planner_slow",
]  # fmt: skip
CameraMode = Literal["truth", "always_clear", "always_occupied"]


class InputFault(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A fault of this kind between from_s and to_s of the run.

    jump_m   east and north, of `pose_jump`
    delay_s  of `planner_slow`: the additional delay of a plan
    """

    kind: FaultKind
    from_s: float = 0.0
    to_s: float = math.inf
    jump_m: tuple[float, float] = (0.0, 0.0)
    delay_s: float = 1.0


class Camera(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An infrastructure camera over an observation area; it is silent from lost_s on."""

    area: str
    says: CameraMode = "truth"
    rate_hz: float = 2.0
    lost_s: float = math.inf


class FaultyInputs:
    """All input faults of a scene."""

    def __init__(self, faults: tuple[InputFault, ...], origin: Origin) -> None:
        self._faults = faults
        self._origin = origin

    def passed(self, body: InboxBody, now_s: float) -> InboxBody | None:
        """The item as it reaches the inbox; None if it is lost."""
        out: InboxBody | None = body
        for fault in self._faults:
            if out is not None and fault.from_s <= now_s < fault.to_s:
                out = self._wrong(fault, out)
        return out

    def plan_delay_s(self, now_s: float) -> float:
        """The additional delay of a plan that is requested now."""
        return sum(
            fault.delay_s
            for fault in self._faults
            if fault.kind == "planner_slow" and fault.from_s <= now_s < fault.to_s
        )

    def _wrong(self, fault: InputFault, body: InboxBody) -> InboxBody | None:
        match fault.kind, body:
            case "pose_lost", GnssFix():
                return None
            case "pose_nan", GnssFix():
                return msgspec.structs.replace(body, latitude_deg=math.nan, heading_rad=math.nan)
            case "pose_jump", GnssFix():
                x_m, y_m = project(self._origin, body.latitude_deg, body.longitude_deg)
                moved = unproject(self._origin, x_m + fault.jump_m[0], y_m + fault.jump_m[1])
                return msgspec.structs.replace(body, latitude_deg=moved[0], longitude_deg=moved[1])
            case "tracks_lost", TrackPercept():
                return None
            case "tracks_empty", TrackPercept():
                return _tracks(body, body.poses_base[:0], body.velocities_base_mps[:0])
            case "tracks_absurd", TrackPercept():
                return _absurd(body)
            case "scans_lost", ObstaclePercept():
                return None
            case _:
                return body


def _tracks(body: TrackPercept, poses: Array, velocities: Array) -> TrackPercept:
    n = len(poses)
    ids, kinds = np.arange(n, dtype=np.int64), np.zeros(n, np.int64)
    return TrackPercept(body.stamp_ns, ids, kinds, poses, velocities, np.full((n, 2), 0.5))


def _absurd(body: TrackPercept) -> TrackPercept:
    """The real tracks and invalid ones: not a number, supersonic, huge, and a duplicate id."""
    poses = np.array([[math.nan, 2.0, 0.0], [12.0, 30.0, 0.0], [1e9, -1e9, 7.0], [9.0, 25.0, math.inf]])
    speeds = np.array([[0.0, 0.0], [0.0, -900.0], [0.0, 0.0], [math.nan, 0.0]])
    sizes = np.array([[0.5, 0.5], [0.5, 0.5], [-3.0, 400.0], [0.5, 0.5]])
    return TrackPercept(
        body.stamp_ns,
        np.concatenate((body.ids, np.array([901, 901, 902, 903]))),
        np.concatenate((body.kinds, np.array([0, 0, 2, 77]))),
        np.vstack((body.poses_base, poses)),
        np.vstack((body.velocities_base_mps, speeds)),
        np.vstack((body.sizes_m, sizes)),
    )


class CameraError(Exception):
    """The map lacks a camera's observation area; the message lists the areas."""


def camera_feeds(cameras: tuple[Camera, ...], road_map: RoadMap) -> tuple["CameraFeed", ...]:
    """Raises CameraError for an area that the map lacks."""
    areas = {area.area_id: area for area in road_map.observation_areas}
    unknown = [camera.area for camera in cameras if camera.area not in areas]
    if unknown:
        raise CameraError(f"no observation area {unknown[0]!r}; there are: {', '.join(areas) or 'none'}")
    return tuple(CameraFeed(camera, areas[camera.area]) for camera in cameras)


class CameraFeed:
    """The reports of a camera about its area."""

    def __init__(self, camera: Camera, area: ObservationArea) -> None:
        self._camera, self._area_id, self._outline = camera, area.area_id, outline_array(area)
        self._due_s = 0.0

    def report(self, now_s: float, now_ns: int, bodies: Bodies) -> PedestrianPresence | None:
        """A report if one is due; call it every step."""
        camera = self._camera
        if now_s < self._due_s or now_s >= camera.lost_s:
            return None
        self._due_s += 1.0 / camera.rate_hz
        match camera.says:
            case "always_clear":
                count = 0
            case "always_occupied":
                count = 1
            case "truth":
                places = np.ascontiguousarray(bodies.poses_map[bodies.kinds == PEDESTRIAN, :2])
                count = int(inside(self._outline, places).sum()) if len(places) else 0
        return PedestrianPresence(now_ns, self._area_id, count, by_server=True)
