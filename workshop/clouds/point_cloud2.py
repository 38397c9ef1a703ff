"""sensor_msgs/PointCloud2 to one point cloud."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from vehicle_agent.signals.point_cloud import PointCloud
from workshop.clouds.fields import cloud_of_fields

# By PointField's datatype.
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}


class PointField(Protocol):
    """sensor_msgs/PointField."""

    name: str
    offset: int
    datatype: int
    count: int


class PointCloud2(Protocol):
    """sensor_msgs/PointCloud2, as far as it is read; `data` is (bytes,) uint8."""

    height: int
    width: int
    fields: Sequence[PointField]
    is_bigendian: bool
    point_step: int
    row_step: int
    data: np.ndarray


class CloudMessageError(Exception):
    """A message whose numbers contradict each other."""


def cloud_of_message(message: PointCloud2, stamp_ns: int) -> PointCloud:
    """The points of a message; CloudMessageError, or MissingFieldError without coordinates."""
    order = ">" if message.is_bigendian else "<"
    width, height, step = message.width, message.height, message.point_step
    names: list[str] = []
    formats: list[str] = []
    offsets: list[int] = []
    for field in message.fields:
        kind = _TYPES.get(field.datatype)
        if kind is None or field.name in names:
            raise CloudMessageError(f"field {field.name} has datatype {field.datatype}, or occurs twice")
        if field.offset + np.dtype(kind).itemsize > step:
            raise CloudMessageError(f"field {field.name} ends behind its point of {step} bytes")
        names.append(field.name)
        formats.append(order + kind)
        offsets.append(field.offset)
    dtype = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": max(step, 1)})
    row_step = message.row_step or width * step
    data = np.ascontiguousarray(message.data, dtype=np.uint8)
    if width * step > row_step or len(data) < row_step * height:
        raise CloudMessageError(
            f"{len(data)} bytes for {height} rows of {row_step} bytes, {width} points each"
        )
    rows = data[: row_step * height].reshape(height, row_step)[:, : width * step]
    points = np.frombuffer(np.ascontiguousarray(rows).tobytes(), dtype=dtype)
    return cloud_of_fields({name: points[name] for name in names}, stamp_ns)
