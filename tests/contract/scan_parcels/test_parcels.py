"""Parcels of scans: what is written is read back, and what is damaged is refused with its reason."""

import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from contract.roads.model import Origin
from contract.scan_parcels.parcels import (
    FIXES,
    HEADER,
    FixRow,
    ParcelError,
    ParcelHeader,
    ParcelWriter,
    PoseRow,
    checked_parcel,
    read_header,
    unpack,
)
from contract.scan_parcels.pcd import PcdError, encoded_points, points_in
from workshop.clouds.recordings import find_recordings

POINTS = np.array([[1.0, 2.0, 0.5], [-3.0, 0.25, 1.5], [8.0, -8.0, 0.0]])
STAMPS = (4_000_000_000, 4_500_000_000)


def header(**changes: object) -> ParcelHeader:
    values: dict[str, object] = {
        "format": 1, "request_id": "scans-1", "vehicle_id": "shuttle-1", "campus_id": "snow-lion",
        "drive_id": "boot-1-0", "number": 0, "origin": Origin(31.0, 121.0), "map_version": "map-1",
        "localization_map": "", "scans": 2, "way_m": 0.5, "first_ns": STAMPS[0], "last_ns": STAMPS[1],
    }  # fmt: skip
    return ParcelHeader(**(values | changes))  # type: ignore[arg-type]


def write(path: Path, said: ParcelHeader | None = None, stamps: tuple[int, ...] = STAMPS) -> Path:
    writer = ParcelWriter(path)
    for stamp_ns in stamps:
        writer.add_scan(stamp_ns, POINTS)
    writer.finish(
        said or header(), [FixRow(STAMPS[0], 31.0, 121.0, 0.02)], [PoseRow(STAMPS[0], 1.0, 2.0, 0.1, 3.0)]
    )
    return path


def rewritten(path: Path, name: str, data: bytes) -> Path:
    """The same parcel with one member changed, or added."""
    with zipfile.ZipFile(path) as before:
        members = {member: before.read(member) for member in before.namelist()}
    with zipfile.ZipFile(path, "w") as after:
        for member, content in (members | {name: data}).items():
            after.writestr(member, content)
    return path


@given(arrays(np.float64, st.tuples(st.integers(1, 40), st.just(3)), elements=st.floats(-100.0, 100.0)))
def test_points_come_back_within_a_millimetre(points: np.ndarray) -> None:
    assert np.abs(points_in(encoded_points(points)) - points).max() <= 0.001


@given(st.binary(max_size=600))
def test_bytes_that_are_no_scan_are_refused(data: bytes) -> None:
    with pytest.raises(PcdError):
        points_in(data)


def test_a_parcel_is_read_as_it_was_written_and_its_folder_by_the_mapping(tmp_path: Path) -> None:
    path = write(tmp_path / "a.zip")
    assert checked_parcel(path) == read_header(path) == header()
    unpack(path, tmp_path / "drive")
    later = write(tmp_path / "b.zip", header(number=1, first_ns=5, last_ns=6), (5, 6))
    unpack(later, tmp_path / "drive")
    lines = (tmp_path / "drive" / FIXES).read_text().splitlines()
    assert len(lines) == 3
    assert lines[1] == "4.000000,31.000000000,121.000000000,0.0200"
    (recording,) = find_recordings(tmp_path / "drive")
    scans = list(recording.scans())
    assert [recording.stamp_ns(number) for number in range(4)] == [5, 6, *STAMPS]
    assert np.allclose(scans[0].points_sensor, POINTS, atol=0.001)


def test_equal_content_gives_equal_bytes(tmp_path: Path) -> None:
    assert write(tmp_path / "a.zip").read_bytes() == write(tmp_path / "b.zip").read_bytes()


@pytest.mark.parametrize(
    ("name", "data", "reason"),
    [
        (HEADER, b"{}", "format None"),
        (HEADER, b'{"format": 1}', "no header"),
        (HEADER, b"[]", "no header"),
        (f"scans/{STAMPS[0]:019d}.pcd", encoded_points(np.zeros((0, 3))), "no point"),
        (f"scans/{STAMPS[0]:019d}.pcd", encoded_points(np.full((2, 3), np.nan)), "not finite"),
        (f"scans/{STAMPS[0]:019d}.pcd", encoded_points(POINTS)[:-3], "ends before"),
        ("scans/0000000000000000007.pcd", encoded_points(POINTS), "3 scans are in it, and it says 2"),
        ("../../etc/passwd", b"x", "does not belong"),
        (FIXES, b"when,where\n", "does not begin with"),
    ],
)
def test_what_is_wrong_in_a_parcel_is_named(tmp_path: Path, name: str, data: bytes, reason: str) -> None:
    path = rewritten(write(tmp_path / "a.zip"), name, data)
    with pytest.raises(ParcelError, match=reason):
        checked_parcel(path)


def test_a_parcel_that_is_cut_off_or_no_zip_is_refused(tmp_path: Path) -> None:
    whole = write(tmp_path / "a.zip").read_bytes()
    for data in (b"", b"PK", whole[: len(whole) // 2], whole[:-1]):
        (tmp_path / "cut.zip").write_bytes(data)
        with pytest.raises(ParcelError):
            checked_parcel(tmp_path / "cut.zip")


def test_a_parcel_whose_members_unpack_to_too_much_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.zip"
    shutil.copyfile(write(tmp_path / "a.zip"), path)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as file:
        file.writestr("scans/0000000000000000009.pcd", b"\0" * (17 * 1024 * 1024))
    with pytest.raises(ParcelError, match="more than a parcel may"):
        checked_parcel(path)
