"""One tick as a scene for Foxglove: the vehicle and what limits its speed, its path, road users with
predictions, signs, and the watched areas."""

import math

import numpy as np

from contract.geometry import Pose2, compose
from contract.roads.areas import outline_array
from contract.roads.model import ObservationArea
from contract.runlog.foxglove import (
    Entity,
    Primitive,
    arrow,
    cube,
    cylinder,
    entity,
    line,
    rgba,
    scene_update,
    text,
)
from contract.wire.messages import TracksBy
from vehicle_agent.config import Body
from vehicle_agent.onboard.driving_view import MOVING_MPS
from vehicle_agent.signals import PEDESTRIAN, TRACK_KINDS, Flow, Path, World

_OWN, _FLEET = rgba(0.15, 0.45, 0.95, 0.85), rgba(0.55, 0.55, 0.6, 0.7)
_FAST, _SLOW = np.array([0.1, 0.7, 0.35]), np.array([0.9, 0.2, 0.1])
_PATH = rgba(0.1, 0.7, 0.35)
_INK = rgba(0.05, 0.05, 0.05)
_KINDS = {
    "pedestrian": rgba(0.95, 0.6, 0.1, 0.9),
    "cyclist": rgba(0.6, 0.35, 0.8, 0.9),
    "vehicle": rgba(0.35, 0.4, 0.5, 0.9),
    "other": rgba(0.6, 0.6, 0.5, 0.9),
}
_HEIGHT_M = {"pedestrian": 1.7, "cyclist": 1.7, "vehicle": 1.6, "other": 1.0}
_YIELDED_TO = rgba(0.9, 0.1, 0.1, 0.95)
_PREDICTED = rgba(0.95, 0.6, 0.1, 0.6)
_CLEAR, _OCCUPIED = rgba(0.1, 0.7, 0.35, 0.8), rgba(0.9, 0.2, 0.1, 0.9)
# Arrows show the way of so many seconds.
_ARROW_S = 1.0
_SIGNS = {
    "stop": rgba(0.8, 0.05, 0.05, 0.95),
    "yield": rgba(0.95, 0.75, 0.1, 0.95),
    "board": rgba(0.55, 0.55, 0.6, 0.9),
    "other": rgba(0.55, 0.55, 0.6, 0.9),
}
_SIGN_NAMES = {"stop": "stop", "yield": "yield", "board": "sign, not read yet", "other": "other sign"}
# Drawn so: perception tells the place of a board, and not its size.
_BOARD_M, _BOARD_TOP_M = 0.75, 2.6
_AHEAD_S = 4.0
_FULL_MPS = 4.0


class ViewerScene:
    """Makes the scenes of one vehicle's ticks."""

    def __init__(
        self, vehicle_id: str, body: Body, areas: tuple[ObservationArea, ...], tracks_by: TracksBy = ""
    ) -> None:
        self._tracks_by = tracks_by
        self._vehicle_id = vehicle_id
        self._size = (body.length_m, body.width_m, body.height_m)
        self._to_centre = Pose2(body.length_m / 2.0 - body.rear_overhang_m, 0.0, 0.0)
        self._outlines = {area.area_id: outline_array(area) for area in areas}

    def scene(self, flow: Flow, utc_ns: int) -> bytes:
        """A SceneUpdate; an entity that is missing from it fades within a second."""
        return scene_update(
            [
                *self._vehicles(flow, utc_ns),
                entity(utc_ns, "path", lines=_path(flow.path)),
                _tracks(flow.world, set(flow.path.yields_to), utc_ns, self._tracks_by),
                _signs(flow, utc_ns),
                entity(utc_ns, "predictions", lines=_predictions(flow.world)),
                entity(utc_ns, "watched areas", lines=self._areas(flow.world)),
            ]
        )

    def _vehicles(self, flow: Flow, utc_ns: int) -> list[Entity]:
        caption = f"{flow.guard_status.mode} {flow.ego.speed_mps * 3.6:.0f} km/h {flow.path.limited_by}"
        own = self._box(utc_ns, self._vehicle_id, flow.ego.pose_map, caption)
        return [
            own,
            *(
                self._box(utc_ns, vehicle.vehicle_id, vehicle.pose_map, vehicle.vehicle_id)
                for vehicle in flow.world.fleet_vehicles
            ),
        ]

    def _box(self, utc_ns: int, name: str, pose_map: Pose2, caption: str) -> Entity:
        centre = compose(pose_map, self._to_centre)
        color = _OWN if name == self._vehicle_id else _FLEET
        label = text(centre, self._size[2] + 0.8, caption, _INK)
        return entity(utc_ns, name, cubes=[cube(centre, self._size, color)], texts=[label])

    def _areas(self, world: World) -> list[Primitive]:
        lines = []
        for watched in world.watched:
            outline = self._outlines.get(watched.area_id)
            if outline is not None:
                color = _OCCUPIED if watched.track_ids or watched.reported else _CLEAR
                lines.append(line(outline, color, thickness_m=0.25, closed=True, z_m=0.15))
        return lines


def _path(path: Path) -> list[Primitive]:
    """The path as a line: green where fast, red where slow."""
    if len(path.points_map) < 2:
        return []
    share = np.clip(path.speeds_mps / _FULL_MPS, 0.0, 1.0)[:, None]
    colors = [rgba(*(round(float(c), 2) for c in row)) for row in share * _FAST + (1.0 - share) * _SLOW]
    return [line(path.points_map, _PATH, colors=colors)]


def _tracks(world: World, yielded_to: set[int], utc_ns: int, tracks_by: TracksBy) -> Entity:
    """Discs and boxes with number, kind and velocity; the metadata say who tracks."""
    tracks = world.tracks
    cubes, cylinders, texts, arrows = [], [], [], []
    for i, number in enumerate(tracks.ids):
        kind = TRACK_KINDS[tracks.kinds[i]]
        centre = Pose2(*(float(value) for value in tracks.poses_map[i]))
        color = _YIELDED_TO if int(number) in yielded_to else _KINDS[kind]
        length_m, width_m = (float(value) for value in tracks.sizes_m[i])
        if tracks.kinds[i] == PEDESTRIAN:
            cylinders.append(cylinder(centre, length_m, _HEIGHT_M[kind], color))
        else:
            cubes.append(cube(centre, (length_m, width_m, _HEIGHT_M[kind]), color))
        texts.append(text(centre, _HEIGHT_M[kind] + 0.3, f"{number} {kind}", _INK, size_m=0.4))
        vx_mps, vy_mps = (float(value) for value in tracks.velocities_map_mps[i])
        speed_mps = math.hypot(vx_mps, vy_mps)
        if speed_mps > MOVING_MPS:
            tail = Pose2(centre.x_m, centre.y_m, math.atan2(vy_mps, vx_mps))
            arrows.append(arrow(tail, speed_mps * _ARROW_S, color))
    known = [("tracks_by", tracks_by)] if tracks_by else []
    return entity(
        utc_ns, "tracks", metadata=known, arrows=arrows, cubes=cubes, cylinders=cylinders, texts=texts
    )


def _signs(flow: Flow, utc_ns: int) -> Entity:
    """Boards on posts, each with what it is taken for and how far it is from the rear axle."""
    cubes, texts = [], []
    for sign in flow.detections.signs:
        x_m, y_m = sign.pose_map.x_m, sign.pose_map.y_m
        post = cube(sign.pose_map, (0.08, 0.08, _BOARD_TOP_M - _BOARD_M), _SIGNS["other"])
        size_m, bottom_m = (0.05, _BOARD_M, _BOARD_M), _BOARD_TOP_M - _BOARD_M
        cubes += [post, cube(sign.pose_map, size_m, _SIGNS[sign.kind], bottom_m)]
        distance_m = math.hypot(x_m - flow.ego.pose_map.x_m, y_m - flow.ego.pose_map.y_m)
        words = f"{_SIGN_NAMES[sign.kind]} {distance_m:.0f} m"
        texts.append(text(Pose2(x_m, y_m, 0.0), _BOARD_TOP_M + 0.4, words, _INK, size_m=0.5))
    return entity(utc_ns, "signs", cubes=cubes, texts=texts)


def _predictions(world: World) -> list[Primitive]:
    """Lines of the moving tracks' predictions, every half second."""
    predictions, tracks = world.predictions, world.tracks
    if len(predictions.poses_map) != len(tracks.ids):
        return []
    speeds = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1])
    shown = np.flatnonzero(predictions.times_s <= _AHEAD_S)[::2]
    moving = np.flatnonzero(speeds > MOVING_MPS)
    return [line(predictions.poses_map[i][shown, :2], _PREDICTED, thickness_m=0.08) for i in moving]
