"""Packets, one after the other, to whole scans."""

import numpy as np

from vehicle_agent.lidar.clouds import cloud_of
from vehicle_agent.lidar.decoding import decode_packets, kind_of, model_of
from vehicle_agent.lidar.models import LidarModel
from vehicle_agent.lidar.packets import PacketError, Packets, each_of
from vehicle_agent.signals.point_cloud import PointCloud

# A turn of the slowest sensor (5 Hz) has fewer; a sensor that never passes the cut must not fill the memory.
_PACKETS_MAX = 4_000
# A packet older than the newest one by less than this came late; by more, the sensor's clock was set.
_LATE_NS = 1_000_000_000


class ScanAssembler:
    """Collects packets until the sensor has turned past the cut; sans I/O.

    A scan begins with the first block whose azimuth is beyond the cut, and ends with the cut itself.
    `refused` counts packets by the code of what is wrong with them: PACKET_CODES, `late_packet` (older than
    one before it) and `other_model` (another sensor sends to the same port).
    """

    def __init__(self, model: LidarModel | None = None, cut_deg: float = 0.0) -> None:
        """model: None for the one that the first good packet names; needed for a sensor's own angles."""
        self.model = model
        self.refused: dict[str, int] = {}
        self.sensor_ns: int | None = None
        self._cut_cdeg = round(100.0 * cut_deg) % 36_000
        self._held: list[tuple[int, Packets]] = []
        self._first_block = 0
        self._phase = 0

    def add(self, stamp_ns: int, packet: bytes) -> PointCloud | None:
        """The scan that this packet completes, if it does. stamp_ns: when the packet came."""
        decoded = self._decoded(packet)
        return None if decoded is None else self._take(stamp_ns, decoded)

    def add_burst(self, stamp_ns: int, burst: list[bytes]) -> list[PointCloud]:
        """The scans that these packets complete. stamp_ns: when the last of them came.

        Packets that are read together are decoded together, in less than half of the time. The
        sensor's clock says how long before the last one the others came.
        """
        decoded = self._decoded_together(burst)
        if not decoded:
            return []
        last_ns, period_ns = int(decoded[-1].sensor_ns[0]), decoded[-1].sensor_time_period_ns
        found: list[PointCloud] = []
        for one in decoded:
            ago_ns = last_ns - int(one.sensor_ns[0])
            if period_ns:
                ago_ns %= period_ns
            cloud = self._take(stamp_ns - (ago_ns if 0 <= ago_ns < _LATE_NS else 0), one)
            if cloud is not None:
                found.append(cloud)
        return found

    def _take(self, stamp_ns: int, decoded: Packets) -> PointCloud | None:
        if self._is_late(decoded):
            return None
        phases = (decoded.azimuths_cdeg[0] - self._cut_cdeg - 1) % 36_000
        last = self._phase if self._held else int(phases[0])
        before = np.concatenate(([last], phases[:-1]))
        self._phase = int(phases[-1])
        # Blocks of one firing have equal azimuths, and noise may turn an azimuth back by a little.
        wraps = np.flatnonzero(phases < before - 18_000)
        self._held.append((stamp_ns, decoded))
        if len(wraps):
            return self._complete(int(wraps[0]))
        if len(self._held) > _PACKETS_MAX:
            self._refuse("bad_azimuth")
            self._held.clear()
        return None

    def finish(self) -> PointCloud | None:
        """The scan that has begun, when a recording ends."""
        cloud = self._cloud(len(self._held), None)
        self._held.clear()
        return cloud

    def _complete(self, end_block: int) -> PointCloud | None:
        cloud = self._cloud(len(self._held), end_block)
        self._held = self._held[-1:]
        self._first_block = end_block
        return cloud

    def _cloud(self, count: int, end_block: int | None) -> PointCloud | None:
        if not count:
            return None
        stamps_ns = np.array([stamp for stamp, _ in self._held[:count]], dtype=np.int64)
        packets = _joined([packets for _, packets in self._held[:count]])
        chosen = np.ones(packets.azimuths_cdeg.shape, dtype=bool)
        chosen[0, : self._first_block] = False
        if end_block is not None:
            chosen[-1, end_block:] = False
        self._first_block = 0
        return cloud_of(packets, _even(stamps_ns, packets), chosen)

    def _decoded_together(self, burst: list[bytes]) -> list[Packets]:
        """The good ones; each bad one is counted."""
        try:
            kinds = {kind_of(packet) for packet in burst}
            if self.model is not None and len(kinds) == 1 and next(iter(kinds))[0].name == self.model.name:
                return each_of(decode_packets(burst, self.model))
        except PacketError:
            # One by one tells which it is, and keeps the others.
            pass
        return self._decoded_singly(burst)

    def _decoded_singly(self, burst: list[bytes]) -> list[Packets]:
        decoded = [self._decoded(packet) for packet in burst]
        return [packets for packets in decoded if packets is not None]

    def _decoded(self, packet: bytes) -> Packets | None:
        try:
            found = model_of(packet)
            if self.model is None:
                self.model = found
            if found.name != self.model.name:
                self._refuse("other_model")
                return None
            return decode_packets([packet], self.model)
        except PacketError as error:
            self._refuse(error.code)
            return None

    def _is_late(self, decoded: Packets) -> bool:
        now_ns, newest_ns = int(decoded.sensor_ns[0]), self.sensor_ns
        if newest_ns is not None and 0 < newest_ns - now_ns < _LATE_NS:
            self._refuse("late_packet")
            return True
        self.sensor_ns = now_ns
        return False

    def _refuse(self, code: str) -> None:
        self.refused[code] = self.refused.get(code, 0) + 1


def _joined(parts: list[Packets]) -> Packets:
    first = parts[0]
    return Packets(
        first.model,
        np.vstack([part.azimuths_cdeg for part in parts]),
        np.vstack([part.distances for part in parts]),
        np.vstack([part.intensities for part in parts]),
        np.concatenate([part.sensor_ns for part in parts]),
        first.returns,
        first.sensor_time_period_ns,
    )


def _even(stamps_ns: np.ndarray, packets: Packets) -> np.ndarray:
    """The packets' stamps by the sensor's clock, from the first one's arrival: a network delivers in bursts.

    A sensor clock that was set, or began its hour again, within these packets leaves the arrivals.
    """
    since_ns = packets.sensor_ns - packets.sensor_ns[0]
    if packets.sensor_time_period_ns:
        since_ns = since_ns % packets.sensor_time_period_ns
    if (np.diff(since_ns) <= 0).any() or since_ns[-1] > 2_000_000_000:
        return stamps_ns
    even: np.ndarray = stamps_ns[0] + since_ns
    return even
