"""CARMEN logs: every form that the published ones have, and those that are damaged."""

import bz2
import gzip
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workshop.carmen.beams import Beams
from workshop.carmen.laser_logs import read_laser_log
from workshop.carmen.log_files import LogFileError

HEADER = "# CARMEN Logfile\nPARAM robot_front_laser_max 80.0 0.1 merci 0.1\n"


def flaser(
    stamp_s: float, readings: list[float], laser: str = "1.0 2.0 0.5", base: str = "1.0 2.0 0.5"
) -> str:
    values = " ".join(f"{value:.2f}" for value in readings)
    return f"FLASER {len(readings)} {values} {laser} {base} {stamp_s:.6f} host 0.25\n"


def robot_laser(stamp_s: float, readings: list[float], remissions: list[float]) -> str:
    values = " ".join(f"{value:.2f}" for value in readings)
    extra = " ".join(["", *(f"{value:.1f}" for value in remissions)])
    return (
        f"ROBOTLASER1 3 -2.35 4.70 0.0125 20.0 0.01 0 {len(readings)} {values} {len(remissions)}{extra} "
        f"1.1 2.0 0.0 1.0 2.0 0.0 0.3 0.1 0.4 0.2 0.0 {stamp_s:.6f} host 7.5\n"
    )


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "log.clf"


@pytest.mark.parametrize(
    ("count", "first_deg", "last_deg"), [(180, -90, 89), (181, -90, 90), (360, -90, 89.5), (361, -90, 90)]
)
def test_a_flaser_line_covers_half_a_turn(path: Path, count: int, first_deg: float, last_deg: float) -> None:
    path.write_text(flaser(5.0, [2.0] * count))
    angles_rad = read_laser_log(path).beams.angles_rad
    assert len(angles_rad) == count
    assert np.degrees(angles_rad[[0, -1]]) == pytest.approx([first_deg, last_deg])


def test_a_robotlaser_line_states_its_own_beams_and_mount(path: Path) -> None:
    path.write_text(robot_laser(5.0, [2.0, 20.0, 3.0], [7.0, 8.0]) + robot_laser(6.0, [2.0, 2.5, 3.0], []))
    log = read_laser_log(path)
    assert log.beams == Beams(-2.35, 0.0125, 3, 20.0)
    assert (log.T_base_laser.x_m, log.T_base_laser.y_m) == pytest.approx((0.1, 0.0))
    assert list(log.stamps_s) == [5.0, 6.0]
    assert np.isnan(log.ranges_m[0]).tolist() == [False, True, False]


def test_the_stamp_is_the_third_last_field(path: Path) -> None:
    path.write_text(HEADER + flaser(1071078718.5, [1.0, 2.0]))
    assert read_laser_log(path).stamps_s.tolist() == [1071078718.5]


def test_readings_that_are_no_return_are_not_a_number(path: Path) -> None:
    line = flaser(1.0, [0.0, 81.91, 80.0, 79.0, -1.0]).replace("79.00", "nan")
    path.write_text(HEADER + line + flaser(2.0, [3.0] * 5))
    ranges_m = read_laser_log(path).ranges_m
    assert np.isnan(ranges_m[0]).all()
    assert ranges_m[1].tolist() == [3.0] * 5


def test_a_greatest_reading_that_repeats_is_no_return_even_if_nothing_states_it(path: Path) -> None:
    path.write_text("".join(flaser(float(i), [3.0, 50.0, 49.0]) for i in range(60)))
    ranges_m = read_laser_log(path).ranges_m
    assert np.isnan(ranges_m[:, 1]).all()
    assert not np.isnan(ranges_m[:, [0, 2]]).any()


def test_the_mount_is_where_the_lines_put_the_laser(path: Path) -> None:
    path.write_text(
        flaser(1.0, [1.0, 2.0], "1.3 2.0 0.0", "1.0 2.0 0.0")
        + flaser(2.0, [1.0, 2.0], f"1.0 2.3 {math.pi / 2:.6f}", f"1.0 2.0 {math.pi / 2:.6f}")
    )
    log = read_laser_log(path)
    assert (log.T_base_laser.x_m, log.T_base_laser.y_m) == pytest.approx((0.3, 0.0), abs=1e-5)
    assert log.notes == ()


def test_a_corrected_laser_pose_is_no_mount(path: Path) -> None:
    path.write_text("".join(flaser(float(i), [1.0, 2.0], f"{i}.0 2.0 0.0", "1.0 2.0 0.0") for i in range(4)))
    log = read_laser_log(path)
    assert log.T_base_laser.x_m == 0.0
    assert "not fixed" in log.notes[0]


def test_odometry_comes_from_odom_lines_where_the_scans_have_none(path: Path) -> None:
    odometry = "".join(f"ODOM {i}.0 0.0 3.1 0.5 0.0 0.0 {i}.0 host 0.0\n" for i in range(4))
    scans = "".join(flaser(i + 0.5, [1.0, 2.0], "0 0 0", "0 0 0") for i in range(3))
    path.write_text(odometry + scans)
    log = read_laser_log(path)
    assert log.odometry[:, 0] == pytest.approx([0.5, 1.5, 2.5])
    assert "ODOM" in log.notes[0]


@pytest.mark.parametrize("compress", [bytes, gzip.compress, bz2.compress])
def test_a_log_is_read_plain_and_compressed(path: Path, compress: type[bytes]) -> None:
    path.write_bytes(compress((HEADER + flaser(1.0, [1.0, 2.0])).encode()))
    assert len(read_laser_log(path)) == 1


@pytest.mark.parametrize("compress", [gzip.compress, bz2.compress])
def test_several_compressed_streams_are_one_log(path: Path, compress: type[bytes]) -> None:
    parts = [compress(flaser(float(i), [1.0, 2.0]).encode()) for i in range(3)]
    path.write_bytes(b"".join(parts))
    assert read_laser_log(path).stamps_s.tolist() == [0.0, 1.0, 2.0]


@pytest.mark.parametrize("compress", [bytes, gzip.compress])
def test_a_log_that_is_cut_in_the_middle_gives_what_was_whole(path: Path, compress: type[bytes]) -> None:
    rng = np.random.default_rng(1)
    whole = "".join(flaser(float(i), list(rng.uniform(1.0, 9.0, 90))) for i in range(200))
    data = compress(whole.encode())
    path.write_bytes(data[: len(data) // 2])
    log = read_laser_log(path)
    assert 80 <= len(log) <= 110
    assert log.stamps_s.tolist() == [float(i) for i in range(len(log))]
    assert "cut off" in log.notes[0]


def test_the_last_line_needs_no_line_break(path: Path) -> None:
    path.write_text((flaser(1.0, [1.0, 2.0]) + flaser(2.0, [1.0, 2.0])).rstrip())
    log = read_laser_log(path)
    assert (len(log), log.notes) == (2, ())


def test_damaged_lines_are_left_out_and_counted(path: Path) -> None:
    good = flaser(2.0, [1.0, 2.0])
    bad = [
        good.replace("FLASER 2", "FLASER 3"),
        good.replace("FLASER 2", "FLASER x"),
        good.replace("2.000000 host", "soon host"),
        good.replace("1.0 2.0 0.5 1.0", "nan 2.0 0.5 1.0"),
        "FLASER\n",
        "ROBOTLASER1 0 0\n",
    ]
    path.write_text(good + "".join(bad) + flaser(3.0, [1.0, 2.0]))
    log = read_laser_log(path)
    assert log.stamps_s.tolist() == [2.0, 3.0]
    assert log.notes == ("6 damaged lines are left out.",)


def test_a_scan_that_came_late_is_put_back(path: Path) -> None:
    path.write_text("".join(flaser(s, [1.0, 2.0 + s]) for s in (1.0, 1.4, 1.2, 1.6)))
    log = read_laser_log(path)
    assert log.stamps_s.tolist() == [1.0, 1.2, 1.4, 1.6]
    assert log.ranges_m[1, 1] == pytest.approx(3.2)
    assert "1 scans came late" in log.notes[0]


def test_a_clock_that_was_set_back_leaves_the_order_of_the_file(path: Path) -> None:
    path.write_text("".join(flaser(s, [1.0, 2.0]) for s in (100.0, 101.0, 5.0, 6.0)))
    log = read_laser_log(path)
    assert log.stamps_s.tolist() == [100.0, 101.0, 5.0, 6.0]
    assert "set back" in log.notes[0]


@pytest.mark.parametrize("data", [b"", b"x,y\n1,2\n", b"\x89PNG\r\n", b"BZh9nothing", b"\x1f\x8bnothing"])
def test_a_file_of_another_kind_is_refused_in_one_sentence(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    with pytest.raises(LogFileError) as refused:
        read_laser_log(path)
    text = str(refused.value)
    assert str(path) in text
    assert text.endswith(".")
    assert "\n" not in text


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.clf"):
        with pytest.raises(LogFileError):
            read_laser_log(path)


@settings(max_examples=60)
@given(st.text(alphabet="FLASER ODM0123456789.-nainf\n", max_size=300))
def test_no_text_breaks_the_reader(text: str) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.clf"
        path.write_text(text + "\n" + flaser(2.0, [1.0, 2.0]))
        log = read_laser_log(path)
    assert np.isfinite(log.stamps_s).all()
    assert log.ranges_m.shape == (len(log), log.beams.count)
