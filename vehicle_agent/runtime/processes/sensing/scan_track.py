"""The vehicle's track for the process that keeps scans, from what the tick sends to the link anyhow."""

import msgspec

from contract.runlog.arrays import dec_hook
from contract.runlog.records import TICK_TOPIC, TickRecord
from contract.scan_parcels.parcels import FixRow, PoseRow
from vehicle_agent.runtime.processes.mailbox import ScanTrack, TickReport
from vehicle_agent.runtime.recording.recorder import LogEntry
from vehicle_agent.signals import GnssFix, InboxItem

_records = msgspec.msgpack.Decoder(TickRecord)
_items: msgspec.msgpack.Decoder[tuple[InboxItem, ...]] = msgspec.msgpack.Decoder(
    tuple[InboxItem, ...], dec_hook=dec_hook
)
# Most ticks bring none; looking for the tag is much cheaper than decoding all that a tick took in.
_FIX_TAG = b"gnss_fix"


def track_of(report: TickReport) -> ScanTrack:
    """The pose in a tick's report, if it has one, and the fixes among what it took in."""
    poses: tuple[PoseRow, ...] = ()
    status = None if report.update is None else report.update.report
    # Before a first pose is known the report has one all the same.
    if status is not None and not any(fault.code == "pose_missing" for fault in status.faults):
        pose = status.pose_map
        poses = (PoseRow(status.stamp_ns, pose.x_m, pose.y_m, pose.yaw_rad, status.speed_mps),)
    fixes: list[FixRow] = []
    for entry in report.entries:
        if isinstance(entry, LogEntry) and entry.topic == TICK_TOPIC and _FIX_TAG in entry.data:
            for item in _items.decode(_records.decode(entry.data).items):
                fix = item.body
                if isinstance(fix, GnssFix):
                    fixes.append(
                        FixRow(fix.stamp_ns, fix.latitude_deg, fix.longitude_deg, fix.position_std_m)
                    )
    return ScanTrack(poses, tuple(fixes))
