"""The process that keeps scans, for one vehicle or for all simulated ones. The tick knows nothing of it.

The link sends it the open requests and the vehicle's track. It looks into the scan ring by itself, and writes
parcels into the vehicle's folder, from where the link uploads them.
"""

import json
import signal
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import structlog

from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.mailbox import Mailbox, ScanReports, ScanTrack, ScanWork
from vehicle_agent.runtime.processes.sensing.new_scans import NewScans
from vehicle_agent.runtime.recording.scan_keeper import ScanKeeper
from vehicle_agent.runtime.recording.scan_parcels import VehicleFrame

log = structlog.get_logger()

# While requests are open: a lidar turns 10 or 20 times a second, and its ring has four places.
BUSY_NS, IDLE_NS = 40_000_000, 500_000_000
REPORT_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class ScanningVehicle:
    """folder: the vehicle's; mail: of its mailboxes; boot: names this process among all of the vehicle."""

    folder: Path
    mail: Path
    scan_ring: Path
    boot: str


class _Vehicle:
    def __init__(self, vehicle: ScanningVehicle, clock: Clock) -> None:
        self._vehicle, self._clock = vehicle, clock
        self.mailbox = Mailbox(vehicle.mail / "scans")
        self._scans = NewScans(vehicle.scan_ring)
        files = AgentFolder(vehicle.folder)
        self._keeper = ScanKeeper(files.scans, vehicle.boot, lambda: frame_of(files))
        self._reported_ns = 0

    @property
    def is_busy(self) -> bool:
        return self._keeper.is_busy

    def step(self) -> None:
        now_ns = self._clock.now_ns()
        for mail in self.mailbox.take():
            if isinstance(mail, ScanWork):
                self._keeper.set_requests(mail.areas, now_ns)
                # A link that has just started hears at once.
                self._report(now_ns)
            elif isinstance(mail, ScanTrack):
                self._keeper.add_track(mail.poses, mail.fixes)
        if not self._keeper.is_busy:
            return
        self._keeper.look(now_ns)
        ready = self._scans.peek()
        utc_ns = now_ns + self._clock.utc_offset_ns()
        if ready is not None:
            if self._keeper.is_wanted(ready.stamp_ns, utc_ns):
                rows = self._scans.take_rows(ready)
                if rows is not None:
                    self._keeper.take(ready.stamp_ns, rows, utc_ns)
            else:
                self._scans.skip(ready)
        if now_ns - self._reported_ns >= REPORT_NS:
            self._report(now_ns)

    def close(self) -> None:
        self._keeper.close()
        self.mailbox.close()

    def _report(self, now_ns: int) -> None:
        self._reported_ns = now_ns
        self.mailbox.post(self._vehicle.mail / "link", ScanReports(self._keeper.reports()))


def frame_of(files: AgentFolder) -> VehicleFrame:
    """By what the vehicle drives. Raises OSError, MapError."""
    road_map = files.road_map()
    in_force = files.localization.in_force()
    version = ""
    if in_force is not None:
        version = str(json.loads((in_force / "index.json").read_bytes()).get("map_version", ""))
    return VehicleFrame(
        files.vehicle().vehicle_id, road_map.campus_id, road_map.origin, road_map.map_version, version
    )


def serve_scans(vehicles: tuple[ScanningVehicle, ...], clock: Clock) -> None:
    """Until SIGTERM."""
    stopping = False

    def stop(_number: int, _frame: FrameType | None) -> None:
        nonlocal stopping
        stopping = True

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    served = [_Vehicle(vehicle, clock) for vehicle in vehicles]
    files = [one.mailbox.fileno() for one in served]
    while not stopping:
        is_busy = any(one.is_busy for one in served)
        clock.wait(clock.now_ns() + (BUSY_NS if is_busy else IDLE_NS), files)
        for one in served:
            one.step()
    for one in served:
        one.close()
