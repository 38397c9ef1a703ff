"""Write one segment of a run as an MCAP file.

A chunk holds about a second of driving and goes to the file whole, so that a killed process loses at most
the chunk it was filling; what is on disk before it can be read and replayed.
"""

import contextlib
from pathlib import Path

import msgspec
from mcap.writer import CompressionType, IndexType, Writer

from contract.runlog.foxglove_schemas import SCHEMAS
from contract.runlog.records import (
    EVENT_TOPIC,
    HEADER_METADATA,
    LOCATION_TOPIC,
    MAP_ATTACHMENT,
    MAP_TOPIC,
    MARK_TOPIC,
    OBSTACLE_TOPIC,
    ONBOARD_TOPIC,
    POINTS_TOPIC,
    POSE_TOPIC,
    PROFILE_ATTACHMENT,
    REPORT_TOPIC,
    SCAN_TOPIC,
    SCENE_TOPIC,
    STATE_ATTACHMENT,
    TICK_TOPIC,
    TRANSFORM_TOPIC,
    RunHeader,
    TickRecord,
    head_digest,
)

CHUNK_BYTES = 64 * 1024

JSON_TOPICS = {
    TRANSFORM_TOPIC: "foxglove.FrameTransform",
    POSE_TOPIC: "foxglove.PoseInFrame",
    LOCATION_TOPIC: "foxglove.LocationFix",
    OBSTACLE_TOPIC: "foxglove.PointCloud",
    POINTS_TOPIC: "foxglove.PointCloud",
    SCENE_TOPIC: "foxglove.SceneUpdate",
    MAP_TOPIC: "foxglove.SceneUpdate",
    MARK_TOPIC: "foxglove.Log",
}


def register_json_channels(writer: Writer) -> dict[str, int]:
    """The channels that viewers draw or show, all but the ticks, by topic."""
    channels: dict[str, int] = {}
    for topic in (REPORT_TOPIC, EVENT_TOPIC, ONBOARD_TOPIC, SCAN_TOPIC):
        schema = writer.register_schema(
            f"campusloop{topic.replace('/', '.')}", "jsonschema", b'{"type":"object"}'
        )
        channels[topic] = writer.register_channel(topic, "json", schema)
    schemas = {
        name: writer.register_schema(name, "jsonschema", SCHEMAS[name])
        for name in dict.fromkeys(JSON_TOPICS.values())
    }
    for topic, name in JSON_TOPICS.items():
        channels[topic] = writer.register_channel(topic, "json", schemas[name])
    return channels


class SegmentWriter:
    """One open segment. `close()` finishes it; a segment that was never closed is still readable."""

    def __init__(
        self, path: Path, header: RunHeader, state: bytes, profile: bytes, road_map_zst: bytes
    ) -> None:
        """state, profile: MessagePack; road_map_zst: the map's JSON, zstd-compressed.

        Raises FileExistsError: a segment is written once.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path = path
        self._offset_ns = header.utc_offset_ns
        self._file = path.open("xb")
        self._writer = Writer(
            self._file,
            chunk_size=CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            index_types=IndexType.ALL,
            enable_crcs=True,
            enable_data_crcs=True,
        )
        self._writer.start(profile="campusloop", library=f"campusloop {header.software}")
        header = msgspec.structs.replace(header, head_sha256=head_digest((state, profile, road_map_zst)))
        fields = {key: str(value) for key, value in msgspec.to_builtins(header).items()}
        self._writer.add_metadata(HEADER_METADATA, fields)
        self._attach(STATE_ATTACHMENT, state)
        self._attach(PROFILE_ATTACHMENT, profile)
        self._attach(MAP_ATTACHMENT, road_map_zst)
        tick_channel = self._writer.register_channel(TICK_TOPIC, "msgpack", schema_id=0)
        self._channels = {TICK_TOPIC: tick_channel} | register_json_channels(self._writer)
        self._file.flush()
        self._flushed_bytes = self._file.tell()
        self._encoder = msgspec.msgpack.Encoder()

    def _attach(self, name: str, data: bytes) -> None:
        self._writer.add_attachment(
            create_time=0, log_time=0, name=name, media_type="application/octet-stream", data=data
        )

    def add_tick(self, record: TickRecord) -> None:
        self.add(TICK_TOPIC, record.stamp_ns, self._encoder.encode(record))

    def add(self, topic: str, stamp_ns: int, data: bytes) -> None:
        """One message; stamp_ns is the vehicle's clock. Raises KeyError for a topic that has no channel."""
        log_time = stamp_ns + self._offset_ns
        self._writer.add_message(
            channel_id=self._channels[topic], log_time=log_time, data=data, publish_time=log_time
        )
        if self._file.tell() != self._flushed_bytes:
            self._file.flush()
            self._flushed_bytes = self._file.tell()

    def close(self) -> None:
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._file.close()

    def abandon(self) -> None:
        """Close the file as it is. What the disk does not take of the last chunk is lost."""
        with contextlib.suppress(OSError):
            self._file.close()
