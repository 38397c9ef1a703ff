"""Samples of a unit from tables and bags, and what is none."""

from pathlib import Path

import numpy as np
import pytest

from workshop.calibration.errors import CalibrationError
from workshop.clouds import bags
from workshop.clouds.errors import CloudFileError
from workshop.motion_calibration.inertial_files import COLUMNS, read_inertial

START_NS = 1_700_000_000_123_456_789
COUNT = 250


def write_bag(path: Path, topics: tuple[str, ...]) -> None:
    """A rosbag2 of Imu messages, 100 a second; the topic's number is its turn rate about x."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    store = bags._typestore()
    types = store.types
    vector, zeros = types["geometry_msgs/msg/Vector3"], np.zeros(9)
    level = types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    with Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        for number, topic in enumerate(topics):
            connection = writer.add_connection(topic, "sensor_msgs/msg/Imu", typestore=store)
            for k in range(COUNT):
                at_ns = START_NS + 10_000_000 * k
                time = types["builtin_interfaces/msg/Time"](sec=at_ns // 10**9, nanosec=at_ns % 10**9)
                message = types["sensor_msgs/msg/Imu"](
                    header=types["std_msgs/msg/Header"](stamp=time, frame_id="imu"),
                    orientation=level, orientation_covariance=zeros,
                    angular_velocity=vector(x=float(number), y=0.2, z=0.3), angular_velocity_covariance=zeros,
                    linear_acceleration=vector(x=0.1, y=0.0, z=9.8), linear_acceleration_covariance=zeros,
                )  # fmt: skip
                writer.write(connection, at_ns, store.serialize_cdr(message, connection.msgtype))


def test_a_topic_of_a_bag_gives_its_samples(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="needs the extra `workshop`")
    write_bag(tmp_path / "one", ("/imu",))
    drive = read_inertial(tmp_path / "one")
    assert drive.start_ns == START_NS
    assert len(drive.stamps_s) == COUNT
    assert drive.rates_radps[7] == pytest.approx([0.0, 0.2, 0.3])
    assert drive.forces_mps2[7] == pytest.approx([0.1, 0.0, 9.8])
    write_bag(tmp_path / "two", ("/imu", "/imu/other"))
    assert read_inertial(tmp_path / "two", "/imu/other").rates_radps[0, 0] == 1.0
    with pytest.raises(CloudFileError, match="2 topics of sensor_msgs/msg/Imu, name one"):
        read_inertial(tmp_path / "two")
    with pytest.raises(CloudFileError, match="no topic /none"):
        read_inertial(tmp_path / "two", "/none")


def test_a_table_keeps_its_stamps_to_the_nanosecond_and_leaves_out_those_that_go_back(tmp_path: Path) -> None:
    rows = [START_NS + 5_000_000 * k for k in range(COUNT)]
    # The driver sends one again, and then goes on.
    rows.insert(100, rows[99])
    lines = [",".join(COLUMNS)]
    lines += [f"{at // 10**9}.{at % 10**9:09d},0,0,0.1,0,0,9.81" for at in rows]
    (tmp_path / "unit.csv").write_text("\n".join(lines) + "\n")
    drive = read_inertial(tmp_path / "unit.csv")
    assert drive.start_ns == START_NS
    assert len(drive.stamps_s) == COUNT
    assert drive.stamps_s[-1] == pytest.approx(0.005 * (COUNT - 1), abs=1e-9)


def test_a_file_that_is_no_table_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "empty.csv").write_text(",".join(COLUMNS) + "\n")
    for name, code in (
        ("bytes.csv", "bad_samples"),
        ("empty.csv", "too_few_samples"),
        ("none.csv", "bad_samples"),
    ):
        with pytest.raises(CalibrationError) as refused:
            read_inertial(tmp_path / name)
        assert refused.value.code == code
