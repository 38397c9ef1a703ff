"""The local link: a crossing's camera speaks to the vehicles around it without the cloud.

One UDP datagram a word on the vehicle's own network, the same JSON as on /ws/infrastructure. Nobody signs
it: whoever can send here can slow the vehicle down, and nothing else (docs/vehicle/onboard.md,
infrastructure).
"""

import socket

import msgspec

from contract.wire.messages import PresenceReport
from vehicle_agent.device_feed import DeviceFeedError, DeviceSensors
from vehicle_agent.runtime.processes.clock import MONOTONIC, Clock
from vehicle_agent.signals import InboxBody, PedestrianPresence

DATAGRAM_BYTES_MAX = 2_000
# Of one poll: a flood must not keep the tick from its work.
WORDS_MAX = 50

_decoder = msgspec.json.Decoder(PresenceReport)


class CameraLink:
    """malformed: datagrams that were no word."""

    def __init__(self, address: str, clock: Clock = MONOTONIC) -> None:
        """address HOST:PORT of the vehicle on its own network. DeviceFeedError when it cannot be opened."""
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
        """(source, word) of everything that has come, stamped with when it was seen, by our own clock."""
        heard: list[tuple[str, InboxBody]] = []
        for _ in range(WORDS_MAX):
            try:
                data = self._socket.recv(DATAGRAM_BYTES_MAX)
            except BlockingIOError:
                break
            try:
                word = _decoder.decode(data)
            except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
                self.malformed += 1
                continue
            seen_ns = self._clock.now_ns() - round(word.age_s * 1e9)
            heard.append(("camera", PedestrianPresence(seen_ns, word.area_id, word.count)))
        return heard

    def close(self) -> None:
        self._socket.close()


class SensorsAndCameras:
    """The tick's devices and the cameras around it as one."""

    def __init__(self, sensors: DeviceSensors, cameras: CameraLink) -> None:
        self._sensors, self._cameras = sensors, cameras

    def poll(self) -> list[tuple[str, InboxBody]]:
        """Devices first; each in the order in which it came."""
        return self._sensors.poll() + self._cameras.poll()

    def close(self) -> None:
        self._sensors.close()
        self._cameras.close()
