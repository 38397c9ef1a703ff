"""Files of points come back as they were written; damaged ones are refused with the reason."""

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.signals.point_cloud import PointCloud
from workshop.clouds.errors import CloudFileError
from workshop.clouds.lzf import LzfError, decompress
from workshop.clouds.recordings import read_cloud

RNG = np.random.default_rng(5)
POINTS = RNG.uniform(-50.0, 50.0, (40, 3)).astype(np.float32)
INTENSITIES = RNG.integers(0, 256, 40).astype(np.float32)
RINGS = RNG.integers(0, 32, 40).astype(np.uint16)
OFFSETS_NS = np.sort(RNG.integers(0, 100_000_000, 40))
OFFSETS_NS[0] = 0
OFFSETS_NS[-1] = 100_000_000
# 2026-05-04T12:00:00Z
DATE_S = 1_777_896_000.0

DTYPE = np.dtype(
    [
        ("x", "<f4"),
        ("y", "<f4"),
        ("z", "<f4"),
        ("pad", "u1", 3),
        ("intensity", "<f4"),
        ("ring", "<u2"),
        ("timestamp", "<f8"),
    ]
)
HEADER = """# .PCD v0.7 - Point Cloud Data file format
VERSION 0.7
FIELDS x y z _ intensity ring timestamp
SIZE 4 4 4 1 4 2 8
TYPE F F F U F U F
COUNT 1 1 1 3 1 1 1
WIDTH 40
HEIGHT 1
VIEWPOINT 0 0 0 1 0 0 0
POINTS 40
DATA {form}
"""


def rows() -> np.ndarray:
    table = np.zeros(40, dtype=DTYPE)
    table["x"], table["y"], table["z"] = POINTS.T
    table["intensity"], table["ring"], table["timestamp"] = INTENSITIES, RINGS, DATE_S + 1e-9 * OFFSETS_NS
    return table


def literal_lzf(data: bytes) -> bytes:
    """LZF without any reference: pieces of at most 32 bytes."""
    return b"".join(
        bytes((len(data[at : at + 32]) - 1,)) + data[at : at + 32] for at in range(0, len(data), 32)
    )


def pcd(form: str) -> bytes:
    table = rows()
    if form == "ascii":
        lines = [
            f"{r['x']:.9g} {r['y']:.9g} {r['z']:.9g} 0 0 0 {r['intensity']} {r['ring']} {r['timestamp']:.9f}"
            for r in table
        ]
        body = "\n".join(lines).encode()
    elif form == "binary":
        body = table.tobytes()
    else:
        raw = b"".join(table[name].tobytes() for name in DTYPE.names or ())
        packed = literal_lzf(raw)
        body = struct.pack("<II", len(packed), len(raw)) + packed
    return HEADER.format(form=form).encode() + body


def ply(form: str) -> bytes:
    header = (
        f"ply\nformat {form} 1.0\ncomment made for a test\nelement vertex 40\nproperty double x\n"
        "property float y\n"
        "property float32 z\nproperty uchar intensity\nproperty ushort ring\nproperty uint t\n"
        "element face 0\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    order = ">" if form == "binary_big_endian" else "<"
    columns = (POINTS[:, 0], POINTS[:, 1], POINTS[:, 2], INTENSITIES, RINGS, OFFSETS_NS)
    if form == "ascii":
        lines = [
            f"{x:.9g} {y:.9g} {z:.9g} {i:.0f} {r} {t}" for x, y, z, i, r, t in zip(*columns, strict=True)
        ]
        return header + "\n".join(lines).encode()
    table = np.zeros(
        40,
        dtype=np.dtype(
            [(str(k), order + kind) for k, kind in enumerate(("f8", "f4", "f4", "u1", "u2", "u4"))]
        ),
    )
    for number, column in enumerate(columns):
        table[str(number)] = column
    return header + table.tobytes()


def written(folder: Path, name: str, data: bytes) -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


def assert_same(cloud: PointCloud, slack_ns: int) -> None:
    assert np.array_equal(cloud.points_sensor, POINTS)
    assert np.array_equal(cloud.intensities, INTENSITIES)
    assert np.array_equal(cloud.rings, RINGS)
    assert np.abs(cloud.offsets_ns - OFFSETS_NS).max() <= slack_ns


@pytest.mark.parametrize("form", ["ascii", "binary", "binary_compressed"])
def test_a_pcd_comes_back(tmp_path: Path, form: str) -> None:
    cloud = read_cloud(written(tmp_path, "a.pcd", pcd(form)))
    # A double of seconds since 1970 has steps of 0.24 us.
    assert_same(cloud, 250)
    assert cloud.stamp_ns == pytest.approx(DATE_S * 1e9, abs=300)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_a_ply_comes_back(tmp_path: Path, form: str) -> None:
    cloud = read_cloud(written(tmp_path, "a.ply", ply(form)), 7)
    assert_same(cloud, 0)
    assert cloud.stamp_ns == 7


def test_kittis_binary_file_comes_back_without_times(tmp_path: Path) -> None:
    table = np.column_stack((POINTS, INTENSITIES)).astype("<f4")
    cloud = read_cloud(written(tmp_path, "000000.bin", table.tobytes()))
    assert np.array_equal(cloud.points_sensor, POINTS)
    assert np.array_equal(cloud.intensities, INTENSITIES)
    assert not cloud.offsets_ns.any()


def test_points_that_are_no_numbers_are_left_out(tmp_path: Path) -> None:
    table = np.column_stack((POINTS, INTENSITIES)).astype("<f4")
    table[3, 1], table[9, 0], table[20, 3] = np.nan, np.inf, np.nan
    cloud = (
        read_cloud(written(tmp_path, "a.bin", table[:, :4].tobytes()))
        if np.isfinite(table[:, :3]).all()
        else None
    )
    assert cloud is None
    with pytest.raises(CloudFileError, match="more than 10 km"):
        read_cloud(written(tmp_path, "a.bin", table.tobytes()))
    table[9, 0] = np.nan
    cloud = read_cloud(written(tmp_path, "a.bin", table.tobytes()))
    assert len(cloud) == 38
    assert np.isfinite(cloud.points_sensor).all()
    assert np.isfinite(cloud.intensities).all()


@pytest.mark.parametrize(
    ("name", "data", "reason"),
    [
        ("a.pcd", b"", "no DATA line"),
        ("a.pcd", b"VERSION 0.7\nDATA binary\n", "FIELDS"),
        ("a.pcd", pcd("binary")[:-1], "ends after"),
        ("a.pcd", pcd("ascii")[:-200], "values for 40 points"),
        ("a.pcd", pcd("ascii")[:-4] + b"1x.2", "no number"),
        ("a.pcd", pcd("binary_compressed")[:-9], "compressed bytes"),
        ("a.pcd", pcd("binary").replace(b"FIELDS x", b"FIELDS u"), "no field x"),
        ("a.pcd", pcd("binary").replace(b"FIELDS x y", b"FIELDS x x"), "twice"),
        ("a.pcd", pcd("binary").replace(b"TYPE F", b"TYPE Q"), "type Q"),
        ("a.pcd", pcd("binary").replace(b"POINTS 40", b"POINTS -4"), "-4 points"),
        ("a.pcd", pcd("binary").replace(b"DATA binary", b"DATA zipped"), "zipped"),
        ("a.ply", b"solid\n", "not ply"),
        ("a.ply", ply("ascii")[:300], "values for 40 vertices"),
        ("a.ply", ply("binary_little_endian")[:-1], "ends after"),
        ("a.ply", ply("ascii").replace(b"format ascii 1.0", b"format morse 1.0"), "morse"),
        ("a.ply", ply("ascii").replace(b"property double x", b"property list uchar int x"), "list"),
        ("a.ply", ply("ascii").replace(b"property double x", b"property double q"), "no field x"),
        ("a.bin", b"\x00" * 30, "whole number"),
        ("a.bin", struct.pack("<4f", 1e9, 0.0, 0.0, 0.0), "10 km"),
        ("a.xyz", b"1 2 3", "none of"),
    ],
)
def test_damaged_files_are_refused_with_the_reason(
    tmp_path: Path, name: str, data: bytes, reason: str
) -> None:
    with pytest.raises(CloudFileError, match=reason):
        read_cloud(written(tmp_path, name, data))


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CloudFileError, match="No such file"):
        read_cloud(tmp_path / "a.pcd")


@given(st.sampled_from(["a.pcd", "a.ply", "a.bin"]), st.integers(0, 5000), st.binary(min_size=1, max_size=8))
def test_a_file_with_changed_bytes_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, name: str, at: int, change: bytes
) -> None:
    whole = {"a.pcd": pcd("binary_compressed"), "a.ply": ply("ascii"), "a.bin": bytes(640)}[name]
    at %= len(whole)
    path = written(tmp_path_factory.getbasetemp(), name, whole[:at] + change + whole[at + len(change) :])
    try:
        cloud = read_cloud(path)
    except CloudFileError:
        return
    assert np.isfinite(cloud.points_sensor).all()


def test_lzf_repeats_what_it_points_back_at() -> None:
    # "ab", then 9 bytes from 2 back (overlapping), then 10 from 5 back with a long length.
    data = b"\x01ab" + bytes(((7 << 5) | 0, 0, 1)) + bytes(((3 << 5) | 0, 4))
    assert decompress(data, 16) == b"ab" + b"ababababa" + b"ababa"


@pytest.mark.parametrize("data", [b"\x20\x05", b"\x01ab\xe0", b"\x01abc"])
def test_broken_lzf_is_refused(data: bytes) -> None:
    with pytest.raises(LzfError):
        decompress(data, 4)


@pytest.mark.parametrize("unit_s", [1.0, 1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("dtype", ["<f8", "<u8"])
def test_times_of_any_unit_are_understood(tmp_path: Path, unit_s: float, dtype: str) -> None:
    if dtype == "<u8" and unit_s == 1.0:
        pytest.skip("whole seconds cannot tell the points of a scan apart")
    table = np.zeros(40, dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("t", dtype)])
    table["t"] = OFFSETS_NS * 1e-9 / unit_s
    kind = dtype[1].upper()
    header = f"FIELDS x y z t\nSIZE 4 4 4 8\nTYPE F F F {kind}\nPOINTS 40\nDATA binary\n".encode()
    cloud = read_cloud(written(tmp_path, "a.pcd", header + table.tobytes()))
    assert np.abs(cloud.offsets_ns - OFFSETS_NS).max() <= (unit_s * 1e9 if dtype == "<u8" else 1)
    assert cloud.stamp_ns == 0
