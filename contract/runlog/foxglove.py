"""Run-log channels that Foxglove draws without our code: JSON messages of its well-known schemas.

Field names and meanings follow the published Foxglove schemas (PoseInFrame, LocationFix, PointCloud,
SceneUpdate); the JSON Schemas here state the part that is used.
"""

import base64
import math
from typing import Any

import msgspec
import numpy as np

from contract.geometry import Pose2

MAP_FRAME = "map"
FLOAT32 = 7

_number = {"type": "number"}
_string = {"type": "string"}
_time = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}
_vector = {"type": "object", "properties": {"x": _number, "y": _number, "z": _number}}
_quaternion = {"type": "object", "properties": {"x": _number, "y": _number, "z": _number, "w": _number}}
_pose = {"type": "object", "properties": {"position": _vector, "orientation": _quaternion}}
_color = {"type": "object", "properties": {"r": _number, "g": _number, "b": _number, "a": _number}}
_cube = {"type": "object", "properties": {"pose": _pose, "size": _vector, "color": _color}}
_line = {
    "type": "object",
    "properties": {
        "type": {"type": "integer"},
        "pose": _pose,
        "thickness": _number,
        "scale_invariant": {"type": "boolean"},
        "points": {"type": "array", "items": _vector},
        "color": _color,
    },
}
_text = {
    "type": "object",
    "properties": {
        "pose": _pose,
        "billboard": {"type": "boolean"},
        "font_size": _number,
        "scale_invariant": {"type": "boolean"},
        "color": _color,
        "text": _string,
    },
}


def _object(title: str, properties: dict[str, Any]) -> bytes:
    return msgspec.json.encode({"title": title, "type": "object", "properties": properties})


SCHEMAS: dict[str, bytes] = {
    "foxglove.PoseInFrame": _object(
        "foxglove.PoseInFrame", {"timestamp": _time, "frame_id": _string, "pose": _pose}
    ),
    "foxglove.LocationFix": _object(
        "foxglove.LocationFix",
        {
            "timestamp": _time,
            "frame_id": _string,
            "latitude": _number,
            "longitude": _number,
            "altitude": _number,
            "position_covariance": {"type": "array", "items": _number},
            "position_covariance_type": {"type": "integer"},
        },
    ),
    "foxglove.PointCloud": _object(
        "foxglove.PointCloud",
        {
            "timestamp": _time,
            "frame_id": _string,
            "pose": _pose,
            "point_stride": {"type": "integer"},
            "fields": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": {
                        "name": _string,
                        "offset": {"type": "integer"},
                        "type": {"type": "integer"},
                    },
                },
            },
            "data": {"type": "string", "contentEncoding": "base64"},
        },
    ),
    "foxglove.SceneUpdate": _object(
        "foxglove.SceneUpdate",
        {
            "deletions": {"type": "array", "items": {"type": "object", "properties": {"id": _string}}},
            "entities": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": {
                        "timestamp": _time,
                        "frame_id": _string,
                        "id": _string,
                        "lifetime": _time,
                        "frame_locked": {"type": "boolean"},
                        "cubes": {"type": "array", "items": _cube},
                        "lines": {"type": "array", "items": _line},
                        "texts": {"type": "array", "items": _text},
                    },
                },
            },
        },
    ),
}

BLUE = {"r": 0.15, "g": 0.45, "b": 0.95, "a": 0.85}
GREY = {"r": 0.55, "g": 0.55, "b": 0.6, "a": 0.7}
GREEN = {"r": 0.1, "g": 0.7, "b": 0.35, "a": 0.9}
BLACK = {"r": 0.05, "g": 0.05, "b": 0.05, "a": 1.0}


def timestamp(utc_ns: int) -> dict[str, int]:
    return {"sec": utc_ns // 1_000_000_000, "nsec": utc_ns % 1_000_000_000}


def pose3(pose_map: Pose2, z_m: float = 0.0) -> dict[str, Any]:
    """A planar pose as position and quaternion."""
    half = pose_map.yaw_rad / 2.0
    return {
        "position": {"x": pose_map.x_m, "y": pose_map.y_m, "z": z_m},
        "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
    }


def pose_in_frame(utc_ns: int, pose_map: Pose2) -> bytes:
    return msgspec.json.encode(
        {"timestamp": timestamp(utc_ns), "frame_id": MAP_FRAME, "pose": pose3(pose_map)}
    )


def location_fix(utc_ns: int, latitude_deg: float, longitude_deg: float, std_m: float) -> bytes:
    variance = std_m * std_m
    return msgspec.json.encode(
        {
            "timestamp": timestamp(utc_ns),
            "frame_id": MAP_FRAME,
            "latitude": latitude_deg,
            "longitude": longitude_deg,
            "altitude": 0.0,
            "position_covariance": [variance, 0, 0, 0, variance, 0, 0, 0, 0],
            "position_covariance_type": 1,
        }
    )


def point_cloud(utc_ns: int, points_map: np.ndarray) -> bytes:
    """points_map (n, 2), drawn at 0.5 m above the ground."""
    points = np.full((len(points_map), 3), 0.5, dtype=np.float32)
    points[:, :2] = points_map
    fields = [{"name": name, "offset": 4 * i, "type": FLOAT32} for i, name in enumerate("xyz")]
    return msgspec.json.encode(
        {
            "timestamp": timestamp(utc_ns),
            "frame_id": MAP_FRAME,
            "pose": pose3(Pose2(0.0, 0.0, 0.0)),
            "point_stride": 12,
            "fields": fields,
            "data": base64.b64encode(points.tobytes()).decode(),
        }
    )


def box_entity(
    utc_ns: int, entity_id: str, centre_map: Pose2, size_m: tuple[float, float, float], own: bool, text: str
) -> dict[str, Any]:
    """A vehicle as a box with a text above it; lives for one second unless renewed."""
    length, width, height = size_m
    return {
        "timestamp": timestamp(utc_ns),
        "frame_id": MAP_FRAME,
        "id": entity_id,
        "lifetime": {"sec": 1, "nsec": 0},
        "frame_locked": False,
        "cubes": [
            {
                "pose": pose3(centre_map, height / 2.0),
                "size": {"x": length, "y": width, "z": height},
                "color": BLUE if own else GREY,
            }
        ],
        "texts": [
            {
                "pose": pose3(centre_map, height + 0.8),
                "billboard": True,
                "font_size": 0.8,
                "scale_invariant": False,
                "color": BLACK,
                "text": text,
            }
        ],
    }


def line_entity(utc_ns: int, entity_id: str, points_map: np.ndarray) -> dict[str, Any]:
    """A path on the ground, (n, 2)."""
    points = [{"x": float(x), "y": float(y), "z": 0.1} for x, y in points_map]
    return {
        "timestamp": timestamp(utc_ns),
        "frame_id": MAP_FRAME,
        "id": entity_id,
        "lifetime": {"sec": 1, "nsec": 0},
        "frame_locked": False,
        "lines": [
            {
                "type": 0,
                "pose": pose3(Pose2(0.0, 0.0, 0.0)),
                "thickness": 0.15,
                "scale_invariant": False,
                "points": points,
                "color": GREEN,
            }
        ],
    }


def scene_update(entities: list[dict[str, Any]]) -> bytes:
    return msgspec.json.encode({"deletions": [], "entities": entities})
