import json
from pathlib import Path

import msgspec
import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from contract.geometry import Pose2
from contract.runlog import foxglove
from contract.runlog.reader import MCAP_MAGIC, RunLogError, messages, open_segment, reports, ticks
from contract.runlog.records import (
    OBSTACLE_TOPIC,
    POSE_TOPIC,
    REPORT_TOPIC,
    SCENE_TOPIC,
    RunHeader,
    TickRecord,
)
from contract.runlog.writer import SegmentWriter
from contract.wire.codec import encode
from contract.wire.messages import Status

# The MCAP opcode of a chunk.
CHUNK = 0x06
UTC_OFFSET_NS = 1_700_000_000_000_000_000


def a_header() -> RunHeader:
    return RunHeader("shuttle-1", "boot-1", 0, "campus", "v1", "gem", "0.1.0", UTC_OFFSET_NS, first_tick=1)


def a_status(stamp_ns: int) -> Status:
    return Status(
        1, stamp_ns, Pose2(1.0, 2.0, 0.5), 3.0, 0.0, 0.0, "autonomous", 0.9, False, "l1", 4.0, "o", 1, "v"
    )


def write_segment(
    path: Path,
    count: int,
    close: bool = True,
    noise: bool = True,
    road_map: bytes = b"{}",
    utc_offset_ns: int = UTC_OFFSET_NS,
) -> SegmentWriter:
    rng = np.random.default_rng(1)
    header = msgspec.structs.replace(a_header(), utc_offset_ns=utc_offset_ns)
    writer = SegmentWriter(path, header, b"state", b"profile", zstandard.compress(road_map))
    for tick in range(1, count + 1):
        stamp_ns = tick * 20_000_000
        items = msgspec.msgpack.encode([rng.bytes(300) if noise else tick])
        writer.add_tick(TickRecord(tick, stamp_ns, 0, msgspec.Raw(items), msgspec.Raw(b"\xc0")))
        if tick % 10 == 0:
            writer.add(REPORT_TOPIC, stamp_ns, encode(a_status(stamp_ns)))
            writer.add(POSE_TOPIC, stamp_ns, foxglove.pose_in_frame(stamp_ns, Pose2(1.0, 2.0, 0.5)))
    if close:
        writer.close()
    return writer


def ticks_before_the_end(path: Path) -> tuple[list[int], str]:
    seen: list[int] = []
    try:
        open_segment(path)
        for record in ticks(path):
            seen.append(record.tick)
    except RunLogError as error:
        return seen, error.code
    return seen, "complete"


def test_what_was_written_is_read_back_in_order(tmp_path: Path) -> None:
    write_segment(tmp_path / "0.mcap", 500)
    segment = open_segment(tmp_path / "0.mcap")
    assert (segment.header.vehicle_id, segment.header.segment) == ("shuttle-1", 0)
    assert (segment.state, segment.profile, segment.road_map) == (b"state", b"profile", b"{}")
    assert [record.tick for record in ticks(tmp_path / "0.mcap")] == list(range(1, 501))


def test_a_time_window_gives_only_its_reports(tmp_path: Path) -> None:
    write_segment(tmp_path / "0.mcap", 500)
    begin, end = UTC_OFFSET_NS + 2_000_000_000, UTC_OFFSET_NS + 4_000_000_000
    stamps = [log_ns for log_ns, _ in reports(tmp_path / "0.mcap", begin, end)]
    assert stamps == [begin + i * 200_000_000 for i in range(10)]


def test_a_segment_whose_writer_was_killed_is_readable_up_to_its_last_chunk(tmp_path: Path) -> None:
    write_segment(tmp_path / "0.mcap", 1000, close=False)
    seen, code = ticks_before_the_end(tmp_path / "0.mcap")
    assert code == "truncated"
    assert seen == list(range(1, len(seen) + 1))
    assert len(seen) > 600


def test_the_file_is_one_that_any_mcap_reader_understands(tmp_path: Path) -> None:
    writer = write_segment(tmp_path / "0.mcap", 20, close=False)
    writer.add(OBSTACLE_TOPIC, 5, foxglove.point_cloud(5, np.zeros((3, 2))))
    blue = foxglove.rgba(0.1, 0.4, 0.9)
    box = foxglove.entity(5, "shuttle-1", cubes=[foxglove.cube(Pose2(0, 0, 0), (4.35, 1.63, 2.28), blue)])
    path = foxglove.entity(5, "path", lines=[foxglove.line(np.zeros((2, 2)), blue)])
    writer.add(SCENE_TOPIC, 5, foxglove.scene_update([box, path]))
    writer.close()
    with (tmp_path / "0.mcap").open("rb") as file:
        found = {
            schema.name: json.loads(message.data)
            for schema, _, message in make_reader(file).iter_messages()
            if schema is not None
        }
    assert found["foxglove.PoseInFrame"]["frame_id"] == "map"
    assert found["foxglove.PointCloud"]["point_stride"] == 12
    assert [entity["id"] for entity in found["foxglove.SceneUpdate"]["entities"]] == ["shuttle-1", "path"]


@settings(max_examples=60, deadline=None)
@given(where=st.floats(0.0, 1.0, exclude_max=True), flip=st.integers(1, 255))
def test_a_flipped_byte_is_never_taken_for_good_driving(
    tmp_path_factory: pytest.TempPathFactory, where: float, flip: int
) -> None:
    path = tmp_path_factory.mktemp("flip") / "0.mcap"
    write_segment(path, 60)
    sound = [(m.topic, m.log_ns, m.data) for m in messages(path)]
    data = bytearray(path.read_bytes())
    data[int(where * len(data))] ^= flip
    path.write_bytes(data)
    seen = []
    try:
        open_segment(path)
        for message in messages(path):
            seen.append((message.topic, message.log_ns, message.data))
    except RunLogError:
        assert seen == sound[: len(seen)]
    else:
        assert seen == sound


def lengths_of(data: bytes) -> list[int]:
    """Where the highest byte stands of every record's length, and of every chunk's uncompressed one."""
    places, at = [], len(MCAP_MAGIC)
    while at + 9 <= len(data) - len(MCAP_MAGIC):
        opcode, length = data[at], int.from_bytes(data[at + 1 : at + 9], "little")
        places.append(at + 8)
        if opcode == CHUNK:
            places.append(at + 9 + 16 + 7)
        at += 9 + length
    return places


def read_whole(path: Path) -> None:
    open_segment(path)
    list(messages(path))


def test_a_length_that_no_memory_could_hold_is_damage(tmp_path: Path) -> None:
    path = tmp_path / "0.mcap"
    write_segment(path, 60)
    sound = path.read_bytes()
    places = lengths_of(sound)
    assert len(places) > 5
    for place in places:
        data = bytearray(sound)
        data[place] ^= 0x80
        path.write_bytes(data)
        with pytest.raises(RunLogError):
            read_whole(path)


@settings(max_examples=40, deadline=None)
@given(where=st.floats(0.0, 1.0, exclude_max=True))
def test_a_segment_cut_anywhere_gives_a_sound_beginning_or_says_why_not(
    tmp_path_factory: pytest.TempPathFactory, where: float
) -> None:
    path = tmp_path_factory.mktemp("cut") / "0.mcap"
    write_segment(path, 300)
    data = path.read_bytes()
    path.write_bytes(data[: int(where * len(data))])
    seen, code = ticks_before_the_end(path)
    assert code in {"truncated", "not_a_run"}
    assert seen == list(range(1, len(seen) + 1))


@pytest.mark.parametrize(
    ("content", "code"), [(b"", "not_a_run"), (b"hello", "not_a_run"), (None, "missing")]
)
def test_what_is_no_run_log_is_refused_by_name(tmp_path: Path, content: bytes | None, code: str) -> None:
    path = tmp_path / "x.mcap"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RunLogError) as caught:
        open_segment(path)
    assert caught.value.code == code
