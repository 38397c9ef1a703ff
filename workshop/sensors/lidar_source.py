"""A lidar's packets or clouds, checked scan by scan."""

from collections import Counter

from vehicle_agent.lidar.models import LidarModel
from vehicle_agent.lidar.plausibility import cloud_faults
from vehicle_agent.lidar.scans import ScanAssembler
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.sensors.source_report import Arrivals, SourceReport, counted

# Spinning lidars turn 5 to 20 times a second.
_RATE_HZ = (4.5, 25.0)
_HOUR_NS = 3_600_000_000_000


class CloudCheck:
    """Scans of one lidar, whatever they come from."""

    def __init__(self) -> None:
        self.arrivals = Arrivals()
        self._faults: Counter[str] = Counter()
        self._before: PointCloud | None = None

    def add(self, arrived_ns: int, cloud: PointCloud, made_ns: int | None) -> None:
        self.arrivals.add(arrived_ns, made_ns)
        self._faults.update(fault.code for fault in cloud_faults(cloud, self._before))
        self._before = cloud

    def report(self, name: str, what: str, refused: dict[str, int]) -> SourceReport:
        clock, latency_ms = self.arrivals.clock()
        findings = [*self.arrivals.findings(*_RATE_HZ), *counted(refused), *counted(dict(self._faults))]
        return SourceReport(
            name,
            what,
            len(self.arrivals.arrived_ns),
            self.arrivals.rate_hz,
            latency_ms,
            clock,
            tuple(findings),
        )


class PacketCheck:
    """Packets of one lidar, as a port receives or a bag holds them."""

    def __init__(self, model: LidarModel | None = None) -> None:
        """model: None for the one that the packets name."""
        self._clouds, self._assembler = CloudCheck(), ScanAssembler(model)
        self._whole = False

    def add(self, arrived_ns: int, packet: bytes) -> None:
        """arrived_ns: UTC, which the sensor's own time is compared with."""
        cloud = self._assembler.add(arrived_ns, packet)
        if cloud is None:
            return
        if self._whole:
            self._clouds.add(arrived_ns, cloud, self._made_ns(arrived_ns))
        # What comes first is the end of a turn.
        self._whole = True

    def report(self, name: str) -> SourceReport:
        model = self._assembler.model
        return self._clouds.report(name, "unknown" if model is None else model.name, self._assembler.refused)

    def _made_ns(self, arrived_ns: int) -> int | None:
        """The newest packet's own time as UTC; one in the hour is put into the nearest hour."""
        made_ns = self._assembler.sensor_ns
        if made_ns is None or made_ns >= _HOUR_NS:
            return made_ns
        off_ns = (made_ns - arrived_ns) % _HOUR_NS
        return arrived_ns + (off_ns if off_ns < _HOUR_NS // 2 else off_ns - _HOUR_NS)
