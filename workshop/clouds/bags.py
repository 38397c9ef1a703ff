"""ROS bags (1 and 2) and MCAP files: their topics, and the scans of a topic of clouds or packets.

`rosbags` reads them; it is in the extra `workshop` (make workshop).
"""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vehicle_agent.lidar.models import LidarModel
from vehicle_agent.lidar.scans import ScanAssembler
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.clouds.errors import CloudFileError
from workshop.clouds.fields import MissingFieldError
from workshop.clouds.point_cloud2 import CloudMessageError, cloud_of_message

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys.store import Typestore

CLOUD_TYPE = "sensor_msgs/msg/PointCloud2"
# Drivers' messages of packets. All have `packets`, each with `stamp`, `data` and perhaps `size`.
PACKET_TYPES = (
    "velodyne_msgs/msg/VelodyneScan",
    "pandar_msgs/msg/PandarScan",
    "hesai_lidar/msg/PandarScan",
    "nebula_msgs/msg/NebulaPackets",
    "hesai_ros_driver/msg/UdpFrame",
)
SUFFIXES = (".bag", ".db3", ".mcap")
# A rosbag2 in SQLite does not say what its messages consist of.
_DEFINITIONS = {
    "velodyne_msgs/msg/VelodyneScan": "std_msgs/Header header\nvelodyne_msgs/VelodynePacket[] packets",
    "velodyne_msgs/msg/VelodynePacket": "builtin_interfaces/Time stamp\nuint8[1206] data",
    "pandar_msgs/msg/PandarScan": "std_msgs/Header header\npandar_msgs/PandarPacket[] packets",
    "pandar_msgs/msg/PandarPacket": "builtin_interfaces/Time stamp\nuint8[1500] data\nuint32 size",
    "hesai_lidar/msg/PandarScan": "std_msgs/Header header\nhesai_lidar/PandarPacket[] packets",
    "hesai_lidar/msg/PandarPacket": "builtin_interfaces/Time stamp\nuint8[1500] data\nuint32 size",
    "nebula_msgs/msg/NebulaPackets": "std_msgs/Header header\nnebula_msgs/NebulaPacket[] packets",
    "nebula_msgs/msg/NebulaPacket": "builtin_interfaces/Time stamp\nuint8[] data",
    "hesai_ros_driver/msg/UdpFrame": "std_msgs/Header header\nhesai_ros_driver/UdpPacket[] packets",
    "hesai_ros_driver/msg/UdpPacket": "builtin_interfaces/Time stamp\nuint8[] data\nuint32 size",
}


@dataclass(frozen=True, slots=True)
class Topic:
    """One topic of a bag."""

    name: str
    kind: str
    messages: int

    @property
    def has_scans(self) -> bool:
        return self.kind == CLOUD_TYPE or self.kind in PACKET_TYPES


@dataclass(frozen=True, slots=True)
class BagMessage:
    """One message: when it was recorded, its raw size, and what it says (of the message's ROS type)."""

    topic: Topic
    recorded_ns: int
    message: Any


def is_bag(path: Path) -> bool:
    """Whether this is a bag: a file by its suffix, a folder by its metadata.yaml."""
    if path.is_dir():
        return (path / "metadata.yaml").exists()
    return path.suffix in SUFFIXES


def topics(path: Path) -> list[Topic]:
    """The topics of a bag by name; CloudFileError."""
    with _reader(path) as reader:
        return _topics(reader)


def messages(path: Path, names: tuple[str, ...] = ()) -> Iterator[BagMessage]:
    """The messages of these topics (all without names) as recorded; CloudFileError."""
    with _reader(path) as reader:
        by_name = {topic.name: topic for topic in _topics(reader)}
        missing = [name for name in names if name not in by_name]
        if missing:
            raise CloudFileError(path, f"no topic {missing[0]}; there are: {', '.join(by_name) or 'none'}")
        chosen = [c for c in reader.connections if not names or c.topic in names]
        for connection, recorded_ns, raw in reader.messages(connections=chosen) if chosen else ():
            try:
                message = reader.deserialize(raw, connection.msgtype)
            # rosbags raises what numpy and struct do where a message is shorter than its type.
            except Exception as error:
                raise CloudFileError(
                    path, f"a message of {connection.topic} ({connection.msgtype}) cannot be read ({error!r})"
                ) from error
            yield BagMessage(by_name[connection.topic], recorded_ns, message)


def topic_with_scans(path: Path, name: str | None = None) -> Topic:
    """The named topic, or the one with most scans; CloudFileError if there is none."""
    found = topics(path)
    scans = [topic for topic in found if topic.has_scans and name in (None, topic.name)]
    if not scans:
        asked = "" if name is None else f" {name}"
        known = ", ".join(f"{topic.name} ({topic.kind})" for topic in found) or "none"
        raise CloudFileError(path, f"no topic{asked} of clouds or lidar packets; there are: {known}")
    return max(scans, key=lambda topic: topic.messages)


def scans(path: Path, topic: Topic, model: LidarModel | None = None) -> Iterator[PointCloud]:
    """The scans of a topic. model: of packets, for a sensor's own angles.

    A recording of packets begins and ends inside a turn: such a piece is left out beside a whole scan.
    """
    if topic.kind == CLOUD_TYPE:
        for item in messages(path, (topic.name,)):
            yield _cloud(path, item)
        return
    before: PointCloud | None = None
    held: PointCloud | None = None
    for number, cloud in enumerate(_assembled(path, topic, model)):
        if held is not None and not (number == 1 and _is_piece(held, cloud)):
            yield held
            before = held
        held = cloud
    if held is not None and not (before is not None and _is_piece(held, before)):
        yield held


def _is_piece(cloud: PointCloud, neighbour: PointCloud) -> bool:
    """Whether a scan is so much shorter than its neighbour that it is no whole turn."""
    lasted_ns, usual_ns = (int(c.offsets_ns.max(initial=0)) for c in (cloud, neighbour))
    return lasted_ns < 0.9 * usual_ns


def _assembled(path: Path, topic: Topic, model: LidarModel | None) -> Iterator[PointCloud]:
    assembler = ScanAssembler(model)
    for item in messages(path, (topic.name,)):
        for stamp_ns, data in packets_of(item):
            cloud = assembler.add(stamp_ns, data)
            if cloud is not None:
                yield cloud
    if assembler.model is None:
        raise CloudFileError(path, f"no packet of {topic.name} is of a known lidar: {assembler.refused}")
    last = assembler.finish()
    if last is not None:
        yield last


def packets_of(item: BagMessage) -> Iterator[tuple[int, bytes]]:
    """(arrival in ns, bytes) of the packets of a message of PACKET_TYPES."""
    for packet in item.message.packets:
        data = np.asarray(packet.data, dtype=np.uint8).tobytes()
        size = getattr(packet, "size", len(data))
        yield stamp_of(packet.stamp), data[:size]


def stamp_of(stamp: Any) -> int:
    """A ROS time in ns."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _cloud(path: Path, item: BagMessage) -> PointCloud:
    stamp_ns = stamp_of(item.message.header.stamp) or item.recorded_ns
    try:
        return cloud_of_message(item.message, stamp_ns)
    except (CloudMessageError, MissingFieldError) as error:
        raise CloudFileError(path, f"a cloud of {item.topic.name}: {error}") from error


def _topics(reader: "AnyReader") -> list[Topic]:
    return [
        Topic(name, info.msgtype or "several types", info.msgcount)
        for name, info in sorted(reader.topics.items())
    ]


@contextmanager
def _reader(path: Path) -> Iterator["AnyReader"]:
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
    except ModuleNotFoundError as error:
        raise CloudFileError(path, "reading bags needs the extra `workshop`: make workshop") from error
    try:
        opened = AnyReader([path], default_typestore=_typestore())
        opened.open()
    except AnyReaderError as error:
        raise CloudFileError(path, f"no bag that can be read: {error}") from error
    # What the storages raise for a file of another kind, or a damaged one.
    except (OSError, ValueError, KeyError, AssertionError, sqlite3.Error) as error:
        raise CloudFileError(path, f"no bag that can be read: {error!r}") from error
    try:
        yield opened
    finally:
        opened.close()


def _typestore() -> "Typestore":
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in _DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store
