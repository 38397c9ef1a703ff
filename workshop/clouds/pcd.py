"""PCD files, version 0.7: ascii, binary and binary_compressed (pointclouds.org, "The PCD file format")."""

from pathlib import Path

import numpy as np

from vehicle_agent.signals.point_cloud import PointCloud
from workshop.clouds.errors import CloudFileError
from workshop.clouds.fields import MissingFieldError, cloud_of_fields
from workshop.clouds.lzf import LzfError, decompress

_TYPES = {"F": "f", "U": "u", "I": "i"}
_POINTS_MAX = 100_000_000
_HEADER_BYTES_MAX = 8_192


def read_pcd(path: Path, stamp_ns: int | None = None) -> PointCloud:
    """The points of a PCD file; CloudFileError."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CloudFileError(path, error.strerror or "cannot be read") from error
    try:
        header, begin = _header(data)
        dtype, count = _layout(header)
        return cloud_of_fields(_columns(header["DATA"][0], data[begin:], dtype, count), stamp_ns)
    except (_PcdError, MissingFieldError, LzfError) as error:
        raise CloudFileError(path, str(error)) from error


class _PcdError(Exception):
    pass


def _header(data: bytes) -> tuple[dict[str, list[str]], int]:
    """The header's lines by keyword, and where the data begin."""
    header: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in header:
        end = data.find(b"\n", at, _HEADER_BYTES_MAX)
        if end < 0:
            raise _PcdError("no PCD file: its header has no DATA line")
        words = data[at:end].decode("ascii", errors="replace").split()
        at = end + 1
        if words and not words[0].startswith("#"):
            header[words[0]] = words[1:]
    if not header["DATA"]:
        raise _PcdError("the DATA line names no format")
    return header, at


def _layout(header: dict[str, list[str]]) -> tuple[np.dtype[np.void], int]:
    """The dtype of one point, and the number of points."""
    try:
        names, sizes, kinds = header["FIELDS"], [int(size) for size in header["SIZE"]], header["TYPE"]
        counts = [int(count) for count in header.get("COUNT", ["1"] * len(names))]
        points = int(header["POINTS"][0]) if "POINTS" in header else _product(header)
    except (KeyError, ValueError, IndexError) as error:
        raise _PcdError(f"the header lacks or misstates {error}") from error
    if not len(names) == len(sizes) == len(kinds) == len(counts) or not names:
        raise _PcdError("FIELDS, SIZE, TYPE and COUNT differ in length")
    if not 0 <= points <= _POINTS_MAX:
        raise _PcdError(f"{points} points")
    fields = []
    for number, (name, size, kind, count) in enumerate(zip(names, sizes, kinds, counts, strict=True)):
        if (
            kind not in _TYPES
            or size not in ((4, 8) if kind == "F" else (1, 2, 4, 8))
            or not 0 < count < 10_000
        ):
            raise _PcdError(f"field {name} has type {kind}, size {size}, count {count}")
        # Padding is called "_", as often as it occurs.
        unique = f"{name}.{number}" if name == "_" else name
        fields.append((unique, f"<{_TYPES[kind]}{size}", (count,)))
    if len({name for name, _, _ in fields}) < len(fields):
        raise _PcdError("a field occurs twice")
    return np.dtype(fields), points


def _product(header: dict[str, list[str]]) -> int:
    return int(header["WIDTH"][0]) * int(header["HEIGHT"][0])


def _columns(form: str, data: bytes, dtype: np.dtype[np.void], count: int) -> dict[str, np.ndarray]:
    if form == "ascii":
        return _ascii(data, dtype, count)
    if form == "binary":
        if len(data) < count * dtype.itemsize:
            raise _PcdError(f"ends after {len(data)} bytes of {count * dtype.itemsize}")
        rows = np.frombuffer(data, dtype=dtype, count=count)
        return {name: rows[name][:, 0] for name in dtype.names or ()}
    if form == "binary_compressed":
        return _compressed(data, dtype, count)
    raise _PcdError(f"DATA {form} is not known")


def _ascii(data: bytes, dtype: np.dtype[np.void], count: int) -> dict[str, np.ndarray]:
    widths = [dtype[name].shape[0] for name in dtype.names or ()]
    words = data.split()
    if len(words) < count * sum(widths):
        raise _PcdError(f"has {len(words)} values for {count} points of {sum(widths)}")
    try:
        values = np.array(words[: count * sum(widths)], dtype=np.float64).reshape(count, sum(widths))
    except ValueError as error:
        raise _PcdError(f"has a value that is no number ({error})") from error
    columns, at = {}, 0
    for name, width in zip(dtype.names or (), widths, strict=True):
        columns[name] = values[:, at]
        at += width
    return columns


def _compressed(data: bytes, dtype: np.dtype[np.void], count: int) -> dict[str, np.ndarray]:
    """Compressed data have one field after the other, each of all points."""
    if len(data) < 8:
        raise _PcdError("ends before its compressed data")
    packed, whole = (int.from_bytes(data[at : at + 4], "little") for at in (0, 4))
    if whole < count * dtype.itemsize or len(data) < 8 + packed:
        raise _PcdError(f"has {len(data) - 8} compressed bytes for {count} points; {packed} were expected")
    raw = decompress(data[8 : 8 + packed], whole)
    columns, at = {}, 0
    for name in dtype.names or ():
        field = dtype[name]
        values = np.frombuffer(raw, dtype=field.base, count=count * field.shape[0], offset=at)
        columns[name] = values.reshape(count, field.shape[0])[:, 0]
        at += count * field.itemsize
    return columns
