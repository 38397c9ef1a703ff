"""A recorded minute of a shuttle driving along a lane, as its agent would upload it."""

import hashlib
from pathlib import Path

import httpx
import msgspec
import numpy as np
import zstandard

from contract.geometry import Pose2
from contract.roads.load import encode_map
from contract.roads.network import RoadNetwork
from contract.runlog.matched_scans import AGREES, NEW, matched_scan
from contract.runlog.records import (
    MARK_TOPIC,
    ONBOARD_TOPIC,
    POINTS_TOPIC,
    REPORT_TOPIC,
    SCAN_TOPIC,
    RunHeader,
    TickRecord,
    recording_mark,
)
from contract.runlog.writer import SegmentWriter
from contract.wire.codec import encode
from contract.wire.messages import LocalizationReport, Status
from contract.wire.reasons import LocalizationPhase
from contract.wire.upload import SIGNATURE_HEADER, segment_path, signed_segment
from tests.e2e.onboard_scene import a_scan, a_scene
from tests.e2e.scripted_shuttle import ScriptedShuttle

TICK_NS = 20_000_000
TICKS_PER_REPORT = 10
UTC_OFFSET_NS = 1_790_000_000_000_000_000
SPEED_MPS = 3.0


def record_run(
    path: Path,
    vehicle_id: str,
    boot_id: str,
    network: RoadNetwork,
    seconds: int,
    brakes_at_s: int = -1,
    mark: tuple[int, str] | None = None,
    sees: bool = False,
    doubts_at_s: int = -1,
    scans: bool = False,
) -> None:
    """The screen names the second, so that a picture tells its moment.

    brakes_at_s  for this second it says that it brakes hard
    mark         an operator's: second and note
    sees         with what it sees and plans
    scans        with a scan each second: a wall that lies on the map, and a thing that does not
    doubts_at_s  from this second on it is in doubt where it is, to 0.8 m
    """
    lane_id = max(network.lines, key=lambda lane: network.lines[lane].length_m)
    header = RunHeader(
        vehicle_id,
        boot_id,
        0,
        network.road_map.campus_id,
        network.map_version,
        "gem",
        "0.1.0",
        UTC_OFFSET_NS,
        1,
    )
    writer = SegmentWriter(path, header, b"", b"", zstandard.compress(encode_map(network.road_map)))
    for tick in range(1, seconds * 50 + 1):
        stamp_ns = tick * TICK_NS
        writer.add_tick(TickRecord(tick, stamp_ns, 0, msgspec.Raw(b"\x90"), msgspec.Raw(b"\xc0")))
        if tick % TICKS_PER_REPORT == 0:
            s_m = min(SPEED_MPS * stamp_ns / 1e9, network.lines[lane_id].length_m)
            status = _status(stamp_ns, network, lane_id, s_m, brakes_at_s)
            if doubts_at_s >= 0:
                is_sure = stamp_ns < doubts_at_s * 1_000_000_000
                phase: LocalizationPhase = "tracking" if is_sure else "doubtful"
                report = LocalizationReport(phase, 0.05 if is_sure else 0.8, 0.9)
                status = msgspec.structs.replace(status, localization=report)
            writer.add(REPORT_TOPIC, stamp_ns, encode(status))
            if scans and tick % 50 == 0:
                pose = Pose2(*network.pose(lane_id, s_m))
                wall = np.column_stack((np.linspace(-8.0, 8.0, 30), np.full(30, 6.0)))
                points = np.vstack((wall, np.tile([2.0, -3.0], (10, 1)))) + np.array([pose.x_m, pose.y_m])
                scan = matched_scan(stamp_ns, pose, 0.75, points, np.repeat([AGREES, NEW], [30, 10]))
                writer.add(SCAN_TOPIC, stamp_ns, msgspec.json.encode(scan))
            if sees:
                x_m, y_m, _ = network.pose(lane_id, s_m)
                if tick % 50 == 0:
                    writer.add(POINTS_TOPIC, stamp_ns, a_scan(stamp_ns + UTC_OFFSET_NS, x_m, y_m))
                scene = msgspec.structs.replace(a_scene(stamp_ns, x_m, y_m), scan=None)
                writer.add(ONBOARD_TOPIC, stamp_ns, encode(scene))
    if mark is not None:
        stamp_ns = mark[0] * 1_000_000_000
        entry = recording_mark(stamp_ns + UTC_OFFSET_NS, mark[1], "mark", "command-of-another-server")
        writer.add(MARK_TOPIC, stamp_ns, msgspec.json.encode(entry))
    writer.close()


def upload_run(shuttle: ScriptedShuttle, path: Path, http: httpx.Client) -> None:
    data = path.read_bytes()
    sha256 = hashlib.sha256(data).hexdigest()
    signature = shuttle.sign(signed_segment(shuttle.vehicle_id, sha256))
    headers = {"Vehicle-Id": shuttle.vehicle_id, SIGNATURE_HEADER: signature}
    answer = http.put(f"{http.base_url.copy_with(path=segment_path(sha256))}", content=data, headers=headers)
    assert answer.is_success, answer.text


def _status(stamp_ns: int, network: RoadNetwork, lane_id: str, s_m: float, brakes_at_s: int) -> Status:
    return Status(
        epoch=1,
        stamp_ns=stamp_ns,
        pose_map=Pose2(*network.pose(lane_id, s_m)),
        speed_mps=SPEED_MPS,
        accel_mps2=-3.0 if stamp_ns // 1_000_000_000 == brakes_at_s else 0.0,
        steer_rad=0.0,
        mode="autonomous",
        battery_ratio=0.8,
        doors_open=False,
        lane_id=lane_id,
        s_m=s_m,
        order_id="",
        revision=0,
        visit_id="",
        screen=f"second {stamp_ns // 1_000_000_000}",
    )
