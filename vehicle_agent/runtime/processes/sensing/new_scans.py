"""New scans in a vehicle's ring, for a process that no datagram tells of them."""

from pathlib import Path

import structlog

from vehicle_agent.device_feed import Array32, DeviceFeedError, ScanReady, ScanRing
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud

log = structlog.get_logger()


class NewScans:
    """The scan ring of one vehicle, from which each scan is taken once; older ones are skipped."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._ring: ScanRing | None = None
        self._seen: ScanReady | None = None
        self._told = ""

    def peek(self) -> ScanReady | None:
        """The newest scan, if it has not been taken. The driver may start later, or again."""
        try:
            self._ring = self._ring or ScanRing(self._path, create=False)
        except DeviceFeedError as error:
            if str(error) != self._told:
                self._told = str(error)
                log.warning("scans.no_ring", error=self._told)
            return None
        newest = self._ring.newest()
        return None if newest == self._seen else newest

    def skip(self, ready: ScanReady) -> None:
        """It is not wanted."""
        self._seen = ready

    def take_rows(self, ready: ScanReady) -> Array32 | None:
        """The scan as it lies in the ring, (n, 5); None: it is overwritten by now."""
        assert self._ring is not None, "a scan was seen in the ring"
        self._seen = ready
        return self._ring.read_rows(ready)

    def take(self, ready: ScanReady) -> PointCloud | None:
        """None: it is overwritten by now."""
        assert self._ring is not None, "a scan was seen in the ring"
        self._seen = ready
        scan = self._ring.read(ready)
        return None if scan is None else point_cloud(ready.stamp_ns, scan[0], scan[1])
