"""Marks and recordings of operators in the run log: once each, in files that replay bit for bit."""

from pathlib import Path

import msgspec
import numpy as np

from campusloop.scenes.path_map import path_map
from contract.geometry import Pose2
from contract.roads.load import encode_map
from contract.runlog.indexed import marks, messages_of
from contract.runlog.matched_scans import AGREES, MatchedScan, matched_scan
from contract.runlog.reader import ticks
from contract.runlog.records import SCAN_TOPIC, RunHeader
from contract.wire.messages import Command, CommandDone
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.recording.recorder import Recorder
from vehicle_agent.runtime.recording.runlog_files import RunLogFiles
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.signals import InboxBody, InboxItem, LidarCondition, LidarConditions, LinkState
from vehicle_agent.stacks.choice import build_car

UTC_OFFSET_NS = 1_800_000_000_000_000_000
TICK_NS = 20_000_000


class RecordedVehicle:
    """A vehicle without sensors that hears commands, one tick at a time."""

    def __init__(self, folder: Path) -> None:
        profile, road_map = (
            Profile(),
            path_map("c", np.array(((0.0, 0.0), (46.0, 0.0))), width_m=3.0, speed_limit_mps=4.0),
        )
        car = build_car(profile, road_map)
        header = RunHeader("s1", "boot-1", 0, "c", road_map.map_version, "gem", "test", UTC_OFFSET_NS, 0)
        self.files = RunLogFiles(folder, msgspec.msgpack.encode(profile), encode_map(road_map))
        self.computer = VehicleComputer(
            car, initial_state(car), Recorder(header, profile.body), UTC_OFFSET_NS
        )
        self.now_ns = 0
        self.done: list[CommandDone] = []
        self.hear(LinkState(0, True, 1, UTC_OFFSET_NS))

    def hear(self, *bodies: InboxBody, ticks: int = 1) -> None:
        for number in range(ticks):
            self.now_ns += TICK_NS
            items = [InboxItem(self.now_ns, "link", k, body) for k, body in enumerate(bodies)]
            outputs = self.computer.run_tick(items if number == 0 else [], self.now_ns)
            self.done += [event for event in outputs.events if isinstance(event, CommandDone)]
            self.files.write(self.computer.entries)


def command(kind: str, text: str, number: int = 1, made_ns: int = UTC_OFFSET_NS + 7) -> Command:
    return msgspec.convert(
        {"epoch": 1, "command_id": f"command-{number}", "kind": kind, "text": text, "made_ns": made_ns},
        Command,
    )


def segments(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.mcap"))


def test_a_mark_is_in_the_file_once_with_the_moment_at_which_it_was_given(tmp_path: Path) -> None:
    vehicle = RecordedVehicle(tmp_path)
    vehicle.hear(command("mark", "A shadow?"), ticks=5)
    # The server repeats it until it has the answer.
    vehicle.hear(command("mark", "A shadow?"), ticks=5)
    vehicle.files.close()
    (segment,) = segments(tmp_path)
    (mark,) = marks(segment)
    assert (mark.message, mark.name, mark.mark_id) == ("A shadow?", "mark", "command-1")
    assert mark.at_ns == UTC_OFFSET_NS + 7
    assert [answer.done for answer in vehicle.done] == [True]


def test_a_recording_begins_and_ends_with_a_file_and_each_replays_bit_for_bit(tmp_path: Path) -> None:
    vehicle = RecordedVehicle(tmp_path)
    vehicle.hear(ticks=10)
    vehicle.hear(command("start_recording", "Rain", 1), ticks=20)
    vehicle.hear(command("mark", "here", 2), ticks=10)
    vehicle.hear(command("stop_recording", "Rain", 3))
    ended = vehicle.files.take_finished()
    vehicle.hear(ticks=10)
    vehicle.files.close()
    before, recorded, after = segments(tmp_path)
    assert [mark.name for mark in marks(recorded)] == ["start_recording", "mark", "stop_recording"]
    assert list(marks(before)) == list(marks(after)) == []
    assert [len(list(ticks(path))) for path in (before, recorded, after)] == [11, 31, 10]
    # What came before was closed when the recording began, so that it is uploaded already.
    assert [segment.segment for segment in ended] == [0]
    for path in (before, recorded, after):
        result = replay_segment(path, build_car)
        assert result.difference is None


def test_a_scene_that_was_asked_for_long_ago_is_refused_with_the_reason(tmp_path: Path) -> None:
    vehicle = RecordedVehicle(tmp_path)
    vehicle.hear(command("show_scene", "", 1, UTC_OFFSET_NS))
    vehicle.hear(command("show_scene", "", 2, UTC_OFFSET_NS - 11_000_000_000))
    assert [answer.done for answer in vehicle.done] == [True, False]
    assert "ask again" in vehicle.done[1].detail


def test_a_matched_scan_has_a_topic_of_its_own_and_the_replay_does_without_it(tmp_path: Path) -> None:
    vehicle = RecordedVehicle(tmp_path)
    vehicle.hear(ticks=3)
    scan = matched_scan(9, Pose2(1.0, 2.0, 0.1), 0.9, np.array([[3.0, 4.0]]), np.array([AGREES]))
    vehicle.hear(LidarConditions(vehicle.now_ns, (LidarCondition("roof", "moved"),)), scan, ticks=3)
    vehicle.files.close()
    (segment,) = segments(tmp_path)
    (message,) = messages_of(segment, (SCAN_TOPIC,))
    assert msgspec.json.decode(message.data, type=MatchedScan) == scan
    assert message.log_ns == UTC_OFFSET_NS + 5 * TICK_NS
    tapes = [bytes(record.items) for record in ticks(segment)]
    assert not any(b"matched_scan" in tape for tape in tapes)
    assert sum(b"lidar_conditions" in tape for tape in tapes) == 1
    assert replay_segment(segment, build_car).difference is None
