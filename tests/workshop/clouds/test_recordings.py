"""Folders and bags become sequences of scans in order."""

import sqlite3
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.vehicle_agent.lidar.packet_bytes import hesai_packets, square_room
from vehicle_agent.lidar.models import XT16
from workshop.clouds import bags
from workshop.clouds.errors import CloudFileError
from workshop.clouds.recordings import find_recordings


def write_bin(path: Path, marks: list[float]) -> None:
    path.write_bytes(b"".join(struct.pack("<4f", mark, 0.0, 0.0, 0.0) for mark in marks))


def test_numbered_files_are_a_sequence_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    for folder, count in (("b", 12), ("a/deep", 3)):
        (tmp_path / folder).mkdir(parents=True)
        for number in range(count):
            write_bin(tmp_path / folder / f"scan{number}.bin", [number])
    write_bin(tmp_path / "left.bin", [0.0])
    write_bin(tmp_path / "right.bin", [0.0])
    found = find_recordings(tmp_path)
    assert [(recording.path.name, len(recording)) for recording in found] == [("deep", 3), ("b", 12)]
    clouds = list(found[1].scans())
    assert [cloud.points_sensor[0, 0] for cloud in clouds] == list(range(12))
    assert [cloud.stamp_ns for cloud in clouds][:3] == [0, 100_000_000, 200_000_000]


def test_a_name_of_nanoseconds_is_the_stamp(tmp_path: Path) -> None:
    for stamp in ("1700000000100000000", "1700000000000000000"):
        write_bin(tmp_path / f"{stamp}.bin", [1.0])
    clouds = list(find_recordings(tmp_path)[0].scans())
    assert [cloud.stamp_ns for cloud in clouds] == [1_700_000_000_000_000_000, 1_700_000_000_100_000_000]


def test_where_nothing_can_be_read_the_reason_is_said(tmp_path: Path) -> None:
    with pytest.raises(CloudFileError, match="no bag, and no folder"):
        find_recordings(tmp_path)
    with pytest.raises(CloudFileError, match="does not exist"):
        find_recordings(tmp_path / "none")


def message_of(store: Any, points: np.ndarray, stamp_ns: int) -> Any:
    types = store.types
    time = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    fields = [
        types["sensor_msgs/msg/PointField"](name=name, offset=at, datatype=kind, count=1)
        for name, at, kind in (("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 16, 7), ("t", 20, 6))
    ]
    # Two rows of points, with four bytes of padding in every point and eight after every row.
    rows = np.zeros(
        (2, len(points) // 2),
        dtype={
            "names": ["p", "i", "t"],
            "formats": [("<f4", 3), "<f4", "<u4"],
            "offsets": [0, 16, 20],
            "itemsize": 24,
        },
    )
    rows["p"] = points.reshape(2, -1, 3)
    rows["i"], rows["t"] = 9.0, np.linspace(0, 1e8, len(points)).reshape(2, -1)
    data = b"".join(row.tobytes() + bytes(8) for row in rows)
    return types["sensor_msgs/msg/PointCloud2"](
        header=types["std_msgs/msg/Header"](stamp=time, frame_id="lidar"), height=2, width=rows.shape[1],
        fields=fields, is_bigendian=False, point_step=24, row_step=24 * rows.shape[1] + 8,
        data=np.frombuffer(data, dtype=np.uint8), is_dense=True,
    )  # fmt: skip


def write_bag(path: Path, storage: str) -> None:
    """A rosbag2 of clouds, packets of an XT16, and texts."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    store = bags._typestore()
    types = store.types
    with Writer(path, version=9, storage_plugin=getattr(StoragePlugin, storage)) as writer:
        clouds = writer.add_connection("/points", "sensor_msgs/msg/PointCloud2", typestore=store)
        packets = writer.add_connection("/packets", "pandar_msgs/msg/PandarScan", typestore=store)
        texts = writer.add_connection("/texts", "std_msgs/msg/String", typestore=store)
        for number in range(3):
            points = np.full((8, 3), number, dtype=np.float32)
            stamp_ns = 5_000_000_000 + number * 100_000_000
            raw = store.serialize_cdr(message_of(store, points, stamp_ns), clouds.msgtype)
            writer.write(clouds, stamp_ns, raw)
        for at in range(0, 620, 155):
            scan = []
            for stamp_ns, data in hesai_packets(XT16, 620, square_room(5.0))[at : at + 155]:
                time = types["builtin_interfaces/msg/Time"](sec=6, nanosec=stamp_ns)
                padded = np.frombuffer(data + bytes(1500 - len(data)), dtype=np.uint8)
                scan.append(types["pandar_msgs/msg/PandarPacket"](stamp=time, data=padded, size=len(data)))
            header = types["std_msgs/msg/Header"](stamp=scan[0].stamp, frame_id="lidar")
            message = types["pandar_msgs/msg/PandarScan"](header=header, packets=scan)
            writer.write(packets, 6_000_000_000 + at, store.serialize_cdr(message, packets.msgtype))
        writer.write(
            texts, 7_000_000_000, store.serialize_cdr(types["std_msgs/msg/String"](data="x"), texts.msgtype)
        )


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_clouds_and_packets_of_a_bag_come_back(tmp_path: Path, storage: str) -> None:
    pytest.importorskip("rosbags", reason="needs the extra `workshop`")
    write_bag(tmp_path / "drive", storage)
    file = next(path for path in (tmp_path / "drive").iterdir() if path.suffix in bags.SUFFIXES)
    for path in (tmp_path / "drive", file):
        assert [topic.name for topic in bags.topics(path)] == ["/packets", "/points", "/texts"]
        # Messages decide which topic it is; the packets are four.
        assert [recording.topic.name for recording in find_recordings(path) if recording.topic] == [
            "/packets"
        ]
        clouds = list(bags.scans(path, bags.topic_with_scans(path, "/points")))
        assert [cloud.points_sensor.tolist() for cloud in clouds] == [[[k] * 3] * 8 for k in (0.0, 1.0, 2.0)]
        assert [cloud.stamp_ns for cloud in clouds] == [5_000_000_000 + k * 100_000_000 for k in range(3)]
        assert clouds[0].offsets_ns[-1] == 100_000_000
        assert set(clouds[0].intensities) == {9.0}
        # 620 packets are two turns and a piece of the third, which is left out.
        turns = list(find_recordings(path)[0].scans())
        assert [len(cloud) for cloud in turns] == [2_000 * 16, 2_000 * 16]
    with pytest.raises(CloudFileError, match="no topic /none"):
        bags.topic_with_scans(tmp_path / "drive", "/none")


def test_files_that_are_no_bags_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="needs the extra `workshop`")
    with sqlite3.connect(tmp_path / "empty.db3"):
        pass
    for name, data in (("text.db3", b"no database"), ("text.mcap", b"no mcap"), ("text.bag", b"no bag")):
        (tmp_path / name).write_bytes(data)
    for name in ("empty.db3", "text.db3", "text.mcap", "text.bag"):
        with pytest.raises(CloudFileError, match="no bag that can be read"):
            bags.topics(tmp_path / name)
