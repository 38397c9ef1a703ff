"""Device values to the vehicle computer, and its outputs to devices.

Small values (fixes, inertial samples, doors, buttons) are msgpack datagrams on the loopback. A lidar scan is
too large for a datagram: its driver writes it into a ring of slots in a memory-mapped file and sends a
`ScanReady`. No side waits: a datagram that is not fetched in time is lost, and a reader detects an
overwritten slot.
"""

import socket
import struct
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from contract.runlog.arrays import dec_hook, enc_hook
from vehicle_agent.mapped_file import mapped
from vehicle_agent.signals import (
    CodeTyped,
    DestinationChoice,
    DoorState,
    GnssFix,
    HelpButton,
    HmiOutput,
    ImuSample,
    InboxBody,
    LidarConditions,
    SeatButton,
    SeatSensor,
    TrackPercept,
)

Array32 = NDArray[np.float32]
DeviceValue = (
    GnssFix
    | ImuSample
    | DoorState
    | SeatSensor
    | SeatButton
    | HelpButton
    | CodeTyped
    | DestinationChoice
    | TrackPercept
    | LidarConditions
)

HOST = "127.0.0.1"
DATAGRAM_BYTES_MAX = 60_000
SLOTS = 4
# Four XT16 with one return turn by 32,000 points each.
POINTS_MAX = 131_072
# x, y, z, intensity, and the time after the stamp in s.
_FLOATS_A_POINT = 5
_SLOT_HEADER = struct.Struct("<qqq")
_SLOT_BYTES = _SLOT_HEADER.size + POINTS_MAX * _FLOATS_A_POINT * 4


class DeviceFeedError(Exception):
    """A feed cannot be opened; the message says what to do."""


class DeviceValues(msgspec.Struct, frozen=True, tag="device_values"):
    """To the tick: values measured since the last datagram."""

    items: tuple[DeviceValue, ...]


class ScanReady(msgspec.Struct, frozen=True, tag="scan_ready"):
    """To the workers: scan `number` is in its slot of the scan ring. left_out: points that had no room."""

    number: int
    stamp_ns: int
    left_out: int = 0


class DeviceOutputs(msgspec.Struct, frozen=True, tag="device_outputs"):
    """From the vehicle computer: the output for screen, speaker and doors."""

    hmi: HmiOutput


Datagram = DeviceValues | ScanReady | DeviceOutputs

_encoder = msgspec.msgpack.Encoder(enc_hook=enc_hook)
_decoder: msgspec.msgpack.Decoder[Datagram] = msgspec.msgpack.Decoder(Datagram, dec_hook=dec_hook)


class DatagramPort:
    """A non-blocking loopback socket. lost: sends without room in the kernel; malformed: bad datagrams."""

    def __init__(self, port: int = 0) -> None:
        """port 0: any port, for sending only. DeviceFeedError if the port is taken."""
        self.lost = 0
        self.malformed = 0
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind((HOST, port))
        except OSError as error:
            self._socket.close()
            raise DeviceFeedError(
                f"port {port} is taken ({error}); end the other simulation or choose another --base-port"
            ) from error

    @property
    def port(self) -> int:
        number: int = self._socket.getsockname()[1]
        return number

    def fileno(self) -> int:
        return self._socket.fileno()

    def send(self, port: int, datagram: Datagram) -> None:
        """Sends a datagram without waiting."""
        try:
            self._socket.sendto(_encoder.encode(datagram), (HOST, port))
        except BlockingIOError:
            self.lost += 1

    def take(self) -> list[Datagram]:
        """All datagrams received, in order."""
        taken: list[Datagram] = []
        while True:
            try:
                data = self._socket.recv(DATAGRAM_BYTES_MAX)
            except BlockingIOError:
                return taken
            try:
                taken.append(_decoder.decode(data))
            except msgspec.DecodeError:
                self.malformed += 1

    def close(self) -> None:
        self._socket.close()


class DeviceSensors:
    """The tick process's view of the feed."""

    def __init__(self, port: int) -> None:
        self._port = DatagramPort(port)

    def poll(self) -> list[tuple[str, InboxBody]]:
        """(source, value) of all values since the last poll."""
        return [
            ("sensors", item)
            for datagram in self._port.take()
            if isinstance(datagram, DeviceValues)
            for item in datagram.items
        ]

    def close(self) -> None:
        self._port.close()


class ScanRing:
    """A memory-mapped file of SLOTS scans. One writer, any number of readers.

    Each slot begins with its scan's number, stamp and point count. The number is -1 while the slot is
    written, and is checked again after reading, so that a torn scan is never used.
    """

    def __init__(self, path: Path, create: bool) -> None:
        """create: create the file (the driver). DeviceFeedError if there is none to read."""
        size = SLOTS * _SLOT_BYTES
        try:
            self._map = mapped(path, size, create)
        except OSError as error:
            raise DeviceFeedError(
                f"no scan ring at {path} ({error}); start the lidar's driver first"
            ) from error
        if create:
            for slot in range(SLOTS):
                _SLOT_HEADER.pack_into(self._map, slot * _SLOT_BYTES, -1, 0, 0)

    def write(
        self,
        number: int,
        stamp_ns: int,
        points_base: Array32,
        intensities: Array32,
        offsets_s: Array32 | None = None,
    ) -> ScanReady:
        """Writes a scan: points_base (n, 3), intensities (n,), offsets_s (n,) of each point from the stamp.

        offsets_s: None for a lidar that measures all points at once.
        Of more than POINTS_MAX points some are left out, evenly, so that no side of the vehicle is blind.
        """
        left_out = max(0, len(points_base) - POINTS_MAX)
        if left_out:
            chosen = np.arange(POINTS_MAX) * len(points_base) // POINTS_MAX
            points_base, intensities = points_base[chosen], intensities[chosen]
            offsets_s = None if offsets_s is None else offsets_s[chosen]
        count = len(points_base)
        offset = number % SLOTS * _SLOT_BYTES
        _SLOT_HEADER.pack_into(self._map, offset, -1, stamp_ns, count)
        rows = self._rows(offset, count)
        rows[:, :3] = points_base
        rows[:, 3] = intensities
        rows[:, 4] = 0.0 if offsets_s is None else offsets_s
        _SLOT_HEADER.pack_into(self._map, offset, number, stamp_ns, count)
        return ScanReady(number, stamp_ns, left_out)

    def read(self, ready: ScanReady) -> tuple[Array32, Array32] | None:
        """Copies of points (n, 3) and intensities (n,); None if the slot holds another scan by now."""
        rows = self.read_rows(ready)
        return None if rows is None else (rows[:, :3].copy(), rows[:, 3].copy())

    def read_rows(self, ready: ScanReady) -> Array32 | None:
        """A copy (n, 5): x, y, z, intensity, and each point's time after the stamp in s; None as `read`."""
        offset = ready.number % SLOTS * _SLOT_BYTES
        number, stamp_ns, count = _SLOT_HEADER.unpack_from(self._map, offset)
        if (number, stamp_ns) != (ready.number, ready.stamp_ns):
            return None
        rows = self._rows(offset, count).copy()
        return rows if _SLOT_HEADER.unpack_from(self._map, offset)[0] == ready.number else None

    def newest(self) -> ScanReady | None:
        """The newest whole scan; None before the first. For readers that no datagram tells of scans."""
        heads = [_SLOT_HEADER.unpack_from(self._map, slot * _SLOT_BYTES) for slot in range(SLOTS)]
        number, stamp_ns, _ = max(heads)
        return ScanReady(number, stamp_ns) if number >= 0 else None

    def _rows(self, offset: int, count: int) -> Array32:
        start = offset + _SLOT_HEADER.size
        flat: Array32 = np.frombuffer(
            self._map, dtype=np.float32, count=count * _FLOATS_A_POINT, offset=start
        )
        return flat.reshape(count, _FLOATS_A_POINT)


def planar_ring_path(lidar_ring: Path) -> Path:
    """The ring of a vehicle's planar scanner, beside that of its lidar."""
    return lidar_ring.with_name(f"{lidar_ring.name}-planar")


def people_ring_path(lidar_ring: Path) -> Path:
    """The ring of a vehicle's planar scanner for people (`[people_scanner]`), beside that of its lidar."""
    return lidar_ring.with_name(f"{lidar_ring.name}-people")
