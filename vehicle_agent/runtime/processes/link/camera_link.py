"""The local link: reports of crossing cameras without the server.

One UDP datagram a report on the vehicle's own network, with the same JSON as on /ws/infrastructure. Datagrams
are not signed: a forged report can slow the vehicle down and has no other effect (docs/vehicle/world.md,
Infrastructure).
"""

import socket

import msgspec

from contract.wire.messages import PresenceReport
from vehicle_agent.device_feed import DeviceFeedError, DeviceSensors
from vehicle_agent.runtime.processes.clock import MONOTONIC, Clock
from vehicle_agent.signals import InboxBody, PedestrianPresence

DATAGRAM_BYTES_MAX = 2_000
# Reports a poll: a flood must not delay the tick.
REPORTS_MAX = 50

_decoder = msgspec.json.Decoder(PresenceReport)


class CameraLink:
    """malformed: number of datagrams that were no report."""

    def __init__(self, address: str, clock: Clock = MONOTONIC) -> None:
        """address: HOST:PORT of the vehicle on its own network. DeviceFeedError if it cannot be opened."""
        host, _, port = address.rpartition(":")
        self.malformed = 0
        self._clock = clock
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind((host, int(port)))
        except (OSError, ValueError, OverflowError) as error:
            self._socket.close()
            raise DeviceFeedError(
                f"cannot listen to cameras on {address!r} ({error}); give HOST:PORT of this vehicle"
            ) from error

    @property
    def port(self) -> int:
        number: int = self._socket.getsockname()[1]
        return number

    def poll(self) -> list[tuple[str, InboxBody]]:
        """(source, report) of each report received, stamped with its detection by this vehicle's clock."""
        received: list[tuple[str, InboxBody]] = []
        for _ in range(REPORTS_MAX):
            try:
                data = self._socket.recv(DATAGRAM_BYTES_MAX)
            except BlockingIOError:
                break
            try:
                report = _decoder.decode(data)
            except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
                self.malformed += 1
                continue
            detected_ns = self._clock.now_ns() - round(report.age_s * 1e9)
            received.append(("camera", PedestrianPresence(detected_ns, report.area_id, report.count)))
        return received

    def close(self) -> None:
        self._socket.close()


class SensorsAndCameras:
    """The tick's devices and the camera link as one."""

    def __init__(self, sensors: DeviceSensors, cameras: CameraLink) -> None:
        self._sensors, self._cameras = sensors, cameras

    def poll(self) -> list[tuple[str, InboxBody]]:
        """The devices' values, then the reports, each in order of arrival."""
        return self._sensors.poll() + self._cameras.poll()

    def close(self) -> None:
        self._sensors.close()
        self._cameras.close()
