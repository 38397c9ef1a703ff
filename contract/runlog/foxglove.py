"""Run-log messages that Foxglove draws without our code: JSON of its well-known schemas (`foxglove_schemas`).

Everything lies in the map frame; `base_link` is the vehicle's rear-axle centre, and a transform between the
two goes with every picture. Lengths are rounded to a centimetre: these are for eyes.
"""

import base64
import math
from collections.abc import Sequence

import msgspec
import numpy as np

from contract.geometry import Pose2

MAP_FRAME, BASE_FRAME = "map", "base_link"
FLOAT32 = 7
COVARIANCE_APPROXIMATED = 1
LINE_STRIP, LINE_LOOP = 0, 1
NO_POSE = Pose2(0.0, 0.0, 0.0)

Color = dict[str, float]
Primitive = dict[str, object]
Entity = dict[str, object]


def rgba(r: float, g: float, b: float, a: float = 1.0) -> Color:
    """Each 0..1."""
    return {"r": r, "g": g, "b": b, "a": a}


def timestamp(utc_ns: int) -> dict[str, int]:
    return {"sec": utc_ns // 1_000_000_000, "nsec": utc_ns % 1_000_000_000}


def pose3(pose_map: Pose2, z_m: float = 0.0) -> dict[str, object]:
    """A planar pose as position and quaternion."""
    return {"position": _vector(pose_map.x_m, pose_map.y_m, z_m), "orientation": _rotation(pose_map.yaw_rad)}


def _vector(x: float, y: float, z: float) -> dict[str, float]:
    return {"x": round(float(x), 2), "y": round(float(y), 2), "z": round(float(z), 2)}


def _rotation(yaw_rad: float) -> dict[str, float]:
    half = yaw_rad / 2.0
    return {"x": 0.0, "y": 0.0, "z": round(math.sin(half), 5), "w": round(math.cos(half), 5)}


# ---------------------------------------------------------------- messages


def frame_transform(utc_ns: int, pose_map: Pose2) -> bytes:
    """Where base_link is in the map."""
    return msgspec.json.encode(
        {
            "timestamp": timestamp(utc_ns),
            "parent_frame_id": MAP_FRAME,
            "child_frame_id": BASE_FRAME,
            "translation": {"x": pose_map.x_m, "y": pose_map.y_m, "z": 0.0},
            "rotation": _rotation(pose_map.yaw_rad),
        }
    )


def pose_in_frame(utc_ns: int, pose_map: Pose2) -> bytes:
    return msgspec.json.encode(
        {"timestamp": timestamp(utc_ns), "frame_id": MAP_FRAME, "pose": pose3(pose_map)}
    )


def location_fix(utc_ns: int, latitude_deg: float, longitude_deg: float, std_m: float) -> bytes:
    """Of base_link: the receiver's driver has moved the antenna's solution there."""
    variance = std_m * std_m
    return msgspec.json.encode(
        {
            "timestamp": timestamp(utc_ns),
            "frame_id": BASE_FRAME,
            "latitude": latitude_deg,
            "longitude": longitude_deg,
            "altitude": 0.0,
            "position_covariance": [variance, 0, 0, 0, variance, 0, 0, 0, 0],
            "position_covariance_type": COVARIANCE_APPROXIMATED,
        }
    )


def point_cloud(utc_ns: int, points_map: np.ndarray) -> bytes:
    """points_map (n, 2), drawn at 0.5 m above the ground."""
    points = np.full((len(points_map), 3), 0.5, dtype=np.float32)
    points[:, :2] = points_map
    return _cloud(utc_ns, NO_POSE, points)


def scan_cloud(utc_ns: int, pose_map: Pose2, points_base: np.ndarray) -> bytes:
    """points_base (n, 3) of one scan, measured at pose_map."""
    return _cloud(utc_ns, pose_map, points_base.astype(np.float32))


def _cloud(utc_ns: int, pose_map: Pose2, points: np.ndarray) -> bytes:
    """points (n, 3) float32, in the frame of that pose."""
    fields = [{"name": name, "offset": 4 * i, "type": FLOAT32} for i, name in enumerate("xyz")]
    return msgspec.json.encode(
        {
            "timestamp": timestamp(utc_ns),
            "frame_id": MAP_FRAME,
            "pose": pose3(pose_map),
            "point_stride": 12,
            "fields": fields,
            "data": base64.b64encode(points.tobytes()).decode(),
        }
    )


def points_of(cloud: bytes) -> np.ndarray:
    """(n, 2) points of a message of `point_cloud`. Raises msgspec.DecodeError, ValueError."""
    data = base64.b64decode(msgspec.json.decode(cloud, type=_CloudData).data)
    points: np.ndarray = np.frombuffer(data, dtype=np.float32).reshape(-1, 3)[:, :2]
    return points


def scan_of(cloud: bytes) -> tuple[Pose2, np.ndarray]:
    """(pose, points (n, 3) in its frame) of a message of `scan_cloud`. Raises like `points_of`."""
    found = msgspec.json.decode(cloud, type=_ScanCloud)
    place, turn = found.pose.position, found.pose.orientation
    points = np.frombuffer(base64.b64decode(found.data), dtype=np.float32).reshape(-1, 3)
    return Pose2(place.x, place.y, 2.0 * math.atan2(turn.z, turn.w)), points


class _CloudData(msgspec.Struct):
    data: str


class _Place(msgspec.Struct):
    x: float
    y: float


class _Turn(msgspec.Struct):
    z: float
    w: float


class _CloudPose(msgspec.Struct):
    position: _Place
    orientation: _Turn


class _ScanCloud(msgspec.Struct):
    data: str
    pose: _CloudPose


def scene_update(entities: list[Entity]) -> bytes:
    return msgspec.json.encode({"deletions": [], "entities": entities})


# ---------------------------------------------------------------- what a scene is made of


def entity(
    utc_ns: int,
    entity_id: str,
    *,
    lifetime_s: int = 1,
    metadata: Sequence[tuple[str, str]] = (),
    arrows: Sequence[Primitive] = (),
    cubes: Sequence[Primitive] = (),
    cylinders: Sequence[Primitive] = (),
    lines: Sequence[Primitive] = (),
    texts: Sequence[Primitive] = (),
) -> Entity:
    """Replaces the entity of the same id; stays for lifetime_s, 0: until it is replaced.

    The published schema requires every kind of primitive, also those that are not drawn.
    """
    return {
        "timestamp": timestamp(utc_ns),
        "frame_id": MAP_FRAME,
        "id": entity_id,
        "lifetime": {"sec": lifetime_s, "nsec": 0},
        "frame_locked": False,
        "metadata": [{"key": key, "value": value} for key, value in metadata],
        "arrows": arrows,
        "cubes": cubes,
        "spheres": [],
        "cylinders": cylinders,
        "lines": lines,
        "triangles": [],
        "texts": texts,
        "models": [],
    }


def arrow(tail_map: Pose2, length_m: float, color: Color, z_m: float = 0.2) -> Primitive:
    """Level, from tail_map in the direction of its yaw; the head is a third of it, and at most 0.5 m."""
    head_m = min(0.5, length_m / 3.0)
    return {
        "pose": pose3(tail_map, z_m),
        "shaft_length": round(length_m - head_m, 2),
        "shaft_diameter": 0.1,
        "head_length": round(head_m, 2),
        "head_diameter": 0.3,
        "color": color,
    }


def cube(
    centre_map: Pose2, size_m: tuple[float, float, float], color: Color, bottom_m: float = 0.0
) -> Primitive:
    """A box of length, width and height that stands on the ground, or bottom_m above it."""
    return {"pose": pose3(centre_map, bottom_m + size_m[2] / 2.0), "size": _vector(*size_m), "color": color}


def cylinder(centre_map: Pose2, diameter_m: float, height_m: float, color: Color) -> Primitive:
    """Upright, on the ground."""
    return {
        "pose": pose3(centre_map, height_m / 2.0),
        "size": _vector(diameter_m, diameter_m, height_m),
        "bottom_scale": 1.0,
        "top_scale": 1.0,
        "color": color,
    }


def line(
    points_map: np.ndarray,
    color: Color,
    *,
    thickness_m: float = 0.15,
    closed: bool = False,
    colors: Sequence[Color] = (),
    z_m: float = 0.1,
) -> Primitive:
    """points_map (n, 2) on the ground; colors: of each point, in place of the one color."""
    return {
        "type": LINE_LOOP if closed else LINE_STRIP,
        "pose": pose3(NO_POSE),
        "thickness": thickness_m,
        "scale_invariant": False,
        "points": [_vector(x, y, z_m) for x, y in points_map],
        "color": color,
        "colors": colors,
        "indices": [],
    }


def text(at_map: Pose2, z_m: float, words: str, color: Color, size_m: float = 0.8) -> Primitive:
    """Turned to whoever looks."""
    return {
        "pose": pose3(at_map, z_m),
        "billboard": True,
        "font_size": size_m,
        "scale_invariant": False,
        "color": color,
        "text": words,
    }
