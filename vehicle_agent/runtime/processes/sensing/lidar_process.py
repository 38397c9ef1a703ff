"""The lidars of a real vehicle as a process: packets in, one scan of all lidars into the scan ring."""

import math
import signal
from pathlib import Path
from types import FrameType
from typing import Literal

import structlog

from vehicle_agent.device_feed import DatagramPort, DeviceValues, ScanRing
from vehicle_agent.lidar.mount_watch import MountDrift
from vehicle_agent.lidar.rig import SILENT, LidarRig, RigLidar, RigScan
from vehicle_agent.lidar.scans import ScanAssembler
from vehicle_agent.runtime.devices.byte_sources import DatagramSource
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.sensors.sensors_file import PlacedLidar
from vehicle_agent.signals import LidarCondition, LidarConditions

log = structlog.get_logger()

WAIT_NS = 50_000_000
GATHER_NS = 5_000_000
# A sensor that sends nonsense is named once in so long.
TELL_AGAIN_NS = 10_000_000_000
STATE_EVERY_NS = 1_000_000_000


class LidarProcess:
    """Assembles the turns of all lidars, and says which are missing and why."""

    def __init__(
        self,
        lidars: tuple[PlacedLidar, ...],
        scan_ring: Path,
        scans_port: int,
        values_port: int,
        clock: Clock,
    ) -> None:
        """values_port: of the tick. Raises ByteSourceError, DeviceFeedError."""
        self._clock, self._values_port = clock, values_port
        self._required = {one.name for one in lidars if one.is_required}
        self._rig = LidarRig([RigLidar(one.name, one.T_base_sensor, one.is_required) for one in lidars])
        self._inputs = [(one.name, DatagramSource(one.port), ScanAssembler(one.model)) for one in lidars]
        self._whole: set[str] = set()
        self._ring, self._scans_port, self._port = (
            ScanRing(scan_ring, create=True),
            scans_port,
            DatagramPort(),
        )
        self._number = 0
        self._missing: dict[str, str] = {}
        self._moved: dict[str, MountDrift] = {}
        self._told: dict[str, tuple[int, dict[str, int]]] = {}
        self._stated: tuple[LidarCondition, ...] = ()
        self._stated_ns: int | None = None
        self._stopping = False

    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        files = [source.fileno() for _, source, _ in self._inputs]
        while not self._stopping:
            self._clock.wait(self._clock.now_ns() + WAIT_NS, files)
            # Packets that are decoded together take less than half of the time.
            self._clock.wait(self._clock.now_ns() + GATHER_NS)
            self.step()
        for _, source, _ in self._inputs:
            source.close()
        self._port.close()

    def step(self) -> None:
        """What has come since the last step."""
        now_ns = self._clock.now_ns()
        for name, source, assembler in self._inputs:
            for cloud in assembler.add_burst(now_ns, source.poll()):
                # What comes first is the end of a turn.
                if name in self._whole:
                    self._give(self._rig.add(name, cloud))
                self._whole.add(name)
            self._tell_refused(name, assembler.refused, now_ns)
        self._give(self._rig.silence(now_ns))
        self._state_conditions(now_ns)

    def _give(self, scan: RigScan | None) -> None:
        if scan is None:
            return
        ready = self._ring.write(
            self._number, scan.stamp_ns, scan.points_base, scan.intensities, scan.offsets_s
        )
        self._number += 1
        self._port.send(self._scans_port, ready)
        for name, code in scan.missing.items():
            if self._missing.get(name) != code:
                log.warning("lidar.missing", name=name, code=code, vehicle_stops=scan.is_blind)
        for name in self._missing.keys() - scan.missing.keys():
            log.info("lidar.back", name=name)
        self._missing = scan.missing
        self._tell_moved(scan.drifts)

    def _state_conditions(self, now_ns: int) -> None:
        """To the tick: which lidars are missing or have moved, at once when that changes."""
        states: dict[str, Literal["silent", "unusable", "moved"]] = dict.fromkeys(self._moved, "moved")
        for name, code in self._missing.items():
            states[name] = "silent" if code == SILENT else "unusable"
        conditions = tuple(
            LidarCondition(name, state, name in self._required) for name, state in sorted(states.items())
        )
        is_due = self._stated_ns is None or now_ns - self._stated_ns >= STATE_EVERY_NS
        if conditions == self._stated and not is_due:
            return
        self._port.send(self._values_port, DeviceValues((LidarConditions(now_ns, conditions),)))
        self._stated, self._stated_ns = conditions, now_ns

    def _tell_moved(self, drifts: dict[str, MountDrift]) -> None:
        for name, drift in drifts.items():
            if name not in self._moved:
                log.warning(
                    "lidar.moved",
                    name=name,
                    height_m=round(drift.height_m, 3),
                    roll_deg=round(math.degrees(drift.roll_rad), 2),
                    pitch_deg=round(math.degrees(drift.pitch_rad), 2),
                )
        for name in self._moved.keys() - drifts.keys():
            log.info("lidar.in_place", name=name)
        self._moved = drifts

    def _tell_refused(self, name: str, refused: dict[str, int], now_ns: int) -> None:
        told_ns, told = self._told.get(name, (0, {}))
        if refused != told and now_ns - told_ns >= TELL_AGAIN_NS:
            log.warning("lidar.refused_packets", name=name, **refused)
            self._told[name] = (now_ns, dict(refused))

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopping = True
