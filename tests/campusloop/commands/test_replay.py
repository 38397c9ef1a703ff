"""`campusloop replay` from the outside: a run as it was, and a run that somebody or something has changed."""

import shutil
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from campusloop.cli import app_of
from campusloop.virtual.solo_drive import VEHICLE_ID, SoloDrive
from contract.roads.load import load_map
from contract.runlog.reader import messages, open_segment
from contract.runlog.records import TICK_TOPIC, TickRecord
from contract.runlog.writer import SegmentWriter
from tests.server.feeds.roads.shipped import CAMPUS_MAP

RUN = CliRunner()
PROFILE = Path(__file__).resolve().parents[3] / "vehicle_agent" / "profiles" / "campus-shuttle.toml"
DRIVE_S = 12.0


@pytest.fixture(scope="module")
def segment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shuttle sets off and drives, looking where it goes."""
    folder = tmp_path_factory.mktemp("drive")
    drive = SoloDrive(load_map(CAMPUS_MAP), folder, 1)
    drive.set_off()
    for _ in range(round(DRIVE_S * 50)):
        drive.step()
    assert drive.world.truth(VEHICLE_ID).speed_mps > 1.0
    drive.vehicle.shut_down()
    (path,) = folder.rglob("*.mcap")
    return path


def rewritten(segment: Path, path: Path, change: Callable[[TickRecord], TickRecord]) -> None:
    """The same run with other tick records, all checksums right."""
    head = open_segment(segment)
    writer = SegmentWriter(path, head.header, head.state, head.profile, zstandard.compress(head.road_map))
    for message in messages(segment):
        data = message.data
        if message.topic == TICK_TOPIC:
            data = msgspec.msgpack.encode(change(msgspec.msgpack.decode(data, type=TickRecord)))
        writer.add(message.topic, message.log_ns, data)
    writer.close()


def test_a_run_replays_exactly(segment: Path) -> None:
    done = RUN.invoke(app_of(), ["replay", str(segment.parent)])
    assert done.exit_code == 0, done.output
    assert "exactly as recorded" in done.output


def test_one_changed_gain_is_named_by_tick_room_and_field(segment: Path, tmp_path: Path) -> None:
    profile = tmp_path / "other.toml"
    profile.write_text(PROFILE.read_text().replace("heading_gain_1ps = 2.4", "heading_gain_1ps = 2.5"))
    done = RUN.invoke(app_of(), ["replay", str(segment), "--profile", str(profile)])
    assert done.exit_code == 1
    assert "room control" in done.output
    assert "tick" in done.output


def test_one_flipped_bit_of_a_recorded_input_is_named_where_it_first_shows(
    segment: Path, tmp_path: Path
) -> None:
    flipped_at: list[int] = []

    def flip(record: TickRecord) -> TickRecord:
        items = msgspec.msgpack.decode(bytes(record.items))
        for item in items:
            body = item[3] if isinstance(item, list) else item["body"]
            if record.tick > 100 and not flipped_at and body.get("type") == "imu_sample":
                flipped_at.append(record.tick)
                body["yaw_rate_radps"] += 0.25
        return msgspec.structs.replace(record, items=msgspec.Raw(msgspec.msgpack.encode(items)))

    other = tmp_path / "flipped.mcap"
    rewritten(segment, other, flip)
    assert flipped_at
    done = RUN.invoke(app_of(), ["replay", str(other)])
    assert done.exit_code == 1, done.output
    assert f"tick {flipped_at[0]}, room " in done.output


def test_a_cut_run_is_replayed_up_to_the_cut_and_said_to_be_cut(segment: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(segment.read_bytes()[: segment.stat().st_size * 3 // 4])
    done = RUN.invoke(app_of(), ["replay", str(cut)])
    assert "ends in the middle of a record" in done.output
    assert "the server's copy" in done.output


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.floats(0.02, 0.95), st.integers(0, 7))
def test_a_damaged_byte_never_passes_for_the_run(
    segment: Path, tmp_path: Path, where: float, bit: int
) -> None:
    damaged = tmp_path / "damaged.mcap"
    shutil.copy(segment, damaged)
    data = bytearray(damaged.read_bytes())
    data[int(where * len(data))] ^= 1 << bit
    damaged.write_bytes(data)
    done = RUN.invoke(app_of(), ["replay", str(damaged)])
    intact = [m.data for m in messages(segment) if m.topic == TICK_TOPIC]
    if done.exit_code == 0:
        # The byte was in an index, which replay does not read.
        assert [m.data for m in messages(damaged) if m.topic == TICK_TOPIC] == intact
    else:
        assert str(damaged) in done.output.replace("\n", "")
