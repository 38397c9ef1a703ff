"""The CAN bus of one vehicle in real time: python-can over IP multicast, on this machine only."""

import time
from collections.abc import Callable

import can

from vehicle_agent.signals import CanFrame

GROUP = "239.74.163"
FIRST_HOST = 10


class LiveBusError(Exception):
    """Multicast does not work on this machine; the message says what to do."""


def channel_of(number: int, base_port: int) -> str:
    """The channel of the number-th simulated vehicle, in the form that the vehicle's gate opens.

    Every bus has an address and a port of its own: Linux delivers a port's datagrams of every joined group
    to every socket bound to that port.
    """
    if not 0 <= number < 256 - FIRST_HOST:
        raise LiveBusError(f"vehicle {number}: one process simulates at most {255 - FIRST_HOST} vehicles")
    return f"udp:{GROUP}.{FIRST_HOST + number}:{base_port + number}"


class LiveBus:
    """The module's side of one channel."""

    def __init__(self, channel: str, now_ns: Callable[[], int] = time.monotonic_ns) -> None:
        """now_ns: the clock that frames are stamped by. LiveBusError when multicast has no route."""
        self._now_ns = now_ns
        self._last_ns = 0
        _, address, port = channel.split(":")
        try:
            self._bus = can.Bus(
                interface="udp_multicast", channel=address, port=int(port), hop_limit=0, fd=False
            )
        except (OSError, can.CanError) as error:
            raise LiveBusError(
                f"no multicast for {channel} ({error}). Give the loopback interface a route: "
                f"ip route add 239.0.0.0/8 dev lo"
            ) from error

    def take(self) -> list[CanFrame]:
        """Frames since the last call, stamped with their arrival; in order even if the clock stood still."""
        frames = []
        while (message := self._bus.recv(timeout=0)) is not None:
            age_ns = round((time.time() - message.timestamp) * 1e9)
            self._last_ns = max(self._last_ns, self._now_ns() - max(0, age_ns))
            frames.append(CanFrame(self._last_ns, message.arbitration_id, bytes(message.data)))
        return frames

    def send(self, frames: tuple[CanFrame, ...]) -> None:
        for frame in frames:
            self._bus.send(
                can.Message(arbitration_id=frame.arbitration_id, data=frame.data, is_extended_id=False)
            )

    def close(self) -> None:
        self._bus.shutdown()
