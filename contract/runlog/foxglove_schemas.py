"""JSON Schemas of the Foxglove messages that a run log holds; the part of each that is used is stated.

A viewer knows a channel by its schema's name and reads it by these fields, which are those of the published
Foxglove schemas.
"""

import msgspec

_Fields = dict[str, object]


def _object(**properties: object) -> _Fields:
    """Every field is required, as in the published schemas."""
    return {"type": "object", "properties": properties, "required": list(properties)}


def _list_of(items: _Fields) -> _Fields:
    return {"type": "array", "items": items}


_number: _Fields = {"type": "number"}
_integer: _Fields = {"type": "integer"}
_string: _Fields = {"type": "string"}
_boolean: _Fields = {"type": "boolean"}
_nanoseconds: _Fields = {"type": "integer", "minimum": 0, "maximum": 999_999_999}
_time = {"title": "time", **_object(sec={"type": "integer", "minimum": 0}, nsec=_nanoseconds)}
_duration = {"title": "duration", **_object(sec=_integer, nsec=_nanoseconds)}
_vector = _object(x=_number, y=_number, z=_number)
_quaternion = _object(x=_number, y=_number, z=_number, w=_number)
_pose = _object(position=_vector, orientation=_quaternion)
_color = _object(r=_number, g=_number, b=_number, a=_number)
_arrow = _object(
    pose=_pose,
    shaft_length=_number,
    shaft_diameter=_number,
    head_length=_number,
    head_diameter=_number,
    color=_color,
)
_cube = _object(pose=_pose, size=_vector, color=_color)
_sphere = _object(pose=_pose, size=_vector, color=_color)
_triangles = _object(
    pose=_pose,
    points=_list_of(_vector),
    color=_color,
    colors=_list_of(_color),
    indices=_list_of(_integer),
)
_model = _object(
    pose=_pose,
    scale=_vector,
    color=_color,
    override_color=_boolean,
    url=_string,
    media_type=_string,
    data={"type": "string", "contentEncoding": "base64"},
)
_cylinder = _object(pose=_pose, size=_vector, bottom_scale=_number, top_scale=_number, color=_color)
_line = _object(
    type=_integer,
    pose=_pose,
    thickness=_number,
    scale_invariant=_boolean,
    points=_list_of(_vector),
    color=_color,
    colors=_list_of(_color),
    indices=_list_of(_integer),
)
_text = _object(
    pose=_pose, billboard=_boolean, font_size=_number, scale_invariant=_boolean, color=_color, text=_string
)
_entity = _object(
    timestamp=_time,
    frame_id=_string,
    id=_string,
    lifetime=_duration,
    frame_locked=_boolean,
    metadata=_list_of(_object(key=_string, value=_string)),
    arrows=_list_of(_arrow),
    cubes=_list_of(_cube),
    spheres=_list_of(_sphere),
    cylinders=_list_of(_cylinder),
    lines=_list_of(_line),
    triangles=_list_of(_triangles),
    texts=_list_of(_text),
    models=_list_of(_model),
)
_deletion = _object(timestamp=_time, type=_integer, id=_string)
_field = _object(name=_string, offset=_integer, type=_integer)

_MESSAGES: dict[str, _Fields] = {
    "foxglove.Log": _object(
        timestamp=_time, level=_integer, message=_string, name=_string, file=_string, line=_integer
    ),
    "foxglove.FrameTransform": _object(
        timestamp=_time,
        parent_frame_id=_string,
        child_frame_id=_string,
        translation=_vector,
        rotation=_quaternion,
    ),
    "foxglove.PoseInFrame": _object(timestamp=_time, frame_id=_string, pose=_pose),
    "foxglove.LocationFix": _object(
        timestamp=_time,
        frame_id=_string,
        latitude=_number,
        longitude=_number,
        altitude=_number,
        position_covariance=_list_of(_number),
        position_covariance_type=_integer,
    ),
    "foxglove.PointCloud": _object(
        timestamp=_time,
        frame_id=_string,
        pose=_pose,
        point_stride=_integer,
        fields=_list_of(_field),
        data={"type": "string", "contentEncoding": "base64"},
    ),
    "foxglove.SceneUpdate": _object(deletions=_list_of(_deletion), entities=_list_of(_entity)),
}

SCHEMAS: dict[str, bytes] = {
    name: msgspec.json.encode({"title": name, **fields}) for name, fields in _MESSAGES.items()
}
