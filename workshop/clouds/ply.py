"""PLY files (Greg Turk, 1994): ascii and binary, of either byte order."""

from pathlib import Path

import numpy as np

from vehicle_agent.signals.point_cloud import PointCloud
from workshop.clouds.errors import CloudFileError
from workshop.clouds.fields import MissingFieldError, cloud_of_fields

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8", "int64": "i8", "uint64": "u8",
}  # fmt: skip
_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_POINTS_MAX = 100_000_000
_HEADER_LINES_MAX = 500


class _PlyError(Exception):
    pass


def read_ply(path: Path, stamp_ns: int | None = None) -> PointCloud:
    """The vertices of a PLY file; CloudFileError."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CloudFileError(path, error.strerror or "cannot be read") from error
    try:
        form, count, properties, begin = _header(data)
        return cloud_of_fields(_columns(form, data[begin:], count, properties), stamp_ns)
    except (_PlyError, MissingFieldError) as error:
        raise CloudFileError(path, str(error)) from error


def _header(data: bytes) -> tuple[str, int, list[tuple[str, str]], int]:
    """(format, vertices, (name, numpy type) of each property, where the data begin)."""
    form, count, at = "", -1, 0
    properties: list[tuple[str, str]] = []
    element = ""
    for number in range(_HEADER_LINES_MAX):
        end = data.find(b"\n", at)
        if end < 0:
            raise _PlyError("no PLY file: its header does not end")
        words = data[at:end].decode("ascii", errors="replace").split()
        at = end + 1
        if number == 0 and words != ["ply"]:
            raise _PlyError("no PLY file: its first line is not ply")
        match words:
            case ["end_header"]:
                break
            case ["format", form, "1.0"] if form in _ORDERS:
                pass
            case ["format", *rest]:
                raise _PlyError(f"format {' '.join(rest)} is not known")
            case ["element", element, size] if size.isdigit():
                if element == "vertex":
                    count = int(size)
                elif count < 0 and size != "0":
                    raise _PlyError(f"element {element} comes before the vertices")
            case ["property", kind, name] if element == "vertex":
                if kind not in _TYPES:
                    raise _PlyError(f"property {name} has type {kind}")
                properties.append((name, _TYPES[kind]))
            case ["property", "list", *_] if element == "vertex":
                raise _PlyError("the vertices have a list")
    if not form or not 0 <= count <= _POINTS_MAX or not properties:
        raise _PlyError("the header names no format, no vertices or none of their properties")
    if len({name for name, _ in properties}) < len(properties):
        raise _PlyError("a property occurs twice")
    return form, count, properties, at


def _columns(form: str, data: bytes, count: int, properties: list[tuple[str, str]]) -> dict[str, np.ndarray]:
    if form == "ascii":
        words = data.split()
        if len(words) < count * len(properties):
            raise _PlyError(f"has {len(words)} values for {count} vertices of {len(properties)}")
        try:
            values = np.array(words[: count * len(properties)], dtype=np.float64)
        except ValueError as error:
            raise _PlyError(f"has a value that is no number ({error})") from error
        table = values.reshape(count, len(properties))
        return {name: table[:, number] for number, (name, _) in enumerate(properties)}
    dtype = np.dtype([(name, _ORDERS[form] + kind) for name, kind in properties])
    if len(data) < count * dtype.itemsize:
        raise _PlyError(f"ends after {len(data)} bytes of {count * dtype.itemsize}")
    rows = np.frombuffer(data, dtype=dtype, count=count)
    return {name: rows[name] for name, _ in properties}
