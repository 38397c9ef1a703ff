"""An LED matrix behind a network controller that speaks DDP, the Distributed Display Protocol, over UDP.

A frame goes out as packets of at most 1440 bytes of pixels (480 of three bytes), in order, each with a header
of ten bytes; the last one has the push flag, which shows the frame. There are no replies.
"""

import socket
import struct

from vehicle_agent.runtime.devices.led_text import Pixels

DDP_PORT = 4048
# Version 1 in the upper two bits; the lowest bit shows the frame.
VERSION_1, PUSH = 0x40, 0x01
# RGB, eight bits a channel; the default output of a controller.
RGB_888, DISPLAY = 0x0B, 0x01
PAYLOAD_BYTES_MAX = 1440
# flags, sequence 1..15, data type, destination, offset in bytes, length
HEADER = struct.Struct(">BBBBIH")


def packets(frame: Pixels, sequence: int) -> list[bytes]:
    """The datagrams of a (height, width, 3) frame, row by row; sequence 1..15."""
    data = frame.tobytes()
    datagrams = []
    for offset in range(0, len(data), PAYLOAD_BYTES_MAX):
        part = data[offset : offset + PAYLOAD_BYTES_MAX]
        flags = VERSION_1 | (PUSH if offset + len(part) == len(data) else 0)
        datagrams.append(HEADER.pack(flags, sequence, RGB_888, DISPLAY, offset, len(part)) + part)
    return datagrams


class DdpMatrix:
    """One controller. lost: packets that could not be sent; the next frame replaces them."""

    def __init__(self, host: str, port: int = DDP_PORT) -> None:
        self.lost = 0
        self._address = (host, port)
        self._sequence = 0
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)

    def send_frame(self, frame: Pixels) -> None:
        """Sends a frame without waiting."""
        self._sequence = self._sequence % 15 + 1
        for packet in packets(frame, self._sequence):
            try:
                self._socket.sendto(packet, self._address)
            except OSError:
                # A missing cable must not end the process.
                self.lost += 1

    def close(self) -> None:
        self._socket.close()
