"""The frame layouts of our DBCs, compiled once to integer bit operations.

cantools reads the file. It is too slow to pack frames at 50 Hz, so each signal becomes a shift and a mask on
the frame as one big-endian integer. tests/vehicle_agent/can compares the two.
"""

import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import cantools
import msgspec

PACMOD, SERVO = "campus_pacmod.dbc", "servo_cart.dbc"
DBC_PATH = Path(__file__).with_name(PACMOD)


class FrameError(Exception):
    """A frame or a value does not fit its layout; the message names both."""


class SignalLayout(msgspec.Struct, frozen=True):
    """`raw = (word >> shift) & mask`; value = raw * scale, two's complement where signed."""

    name: str
    shift: int
    mask: int
    signed: bool
    scale: float
    raw_min: int
    raw_max: int

    def raw(self, value: float) -> int:
        """The bits of a value, clamped to the signal's declared range. FrameError unless finite."""
        if not math.isfinite(value):
            raise FrameError(f"{self.name} = {value}: a command must be a finite number")
        return min(max(round(value / self.scale), self.raw_min), self.raw_max) & self.mask

    def is_within_range(self, word: int) -> bool:
        """False for the codes above the range, which mean an error or a value that is not available."""
        return self.raw_min <= self._raw(word) <= self.raw_max

    def read(self, word: int) -> float:
        return self._raw(word) * self.scale

    def _raw(self, word: int) -> int:
        raw = (word >> self.shift) & self.mask
        if self.signed and raw > self.mask >> 1:
            raw -= self.mask + 1
        return raw


class MessageLayout(msgspec.Struct, frozen=True):
    """One message of the DBC; `signals` by name."""

    name: str
    arbitration_id: int
    length: int
    signals: dict[str, SignalLayout]

    def pack(self, values: Mapping[str, float]) -> bytes:
        """Frame data; signals that are not given are 0. KeyError for a signal the message does not have."""
        word = 0
        for name, value in values.items():
            signal = self.signals[name]
            word |= signal.raw(value) << signal.shift
        return word.to_bytes(self.length, "big")

    def word(self, data: bytes) -> int:
        """The frame as one integer for `SignalLayout.read`. FrameError for a wrong length."""
        if len(data) != self.length:
            raise FrameError(
                f"{self.name} (0x{self.arbitration_id:X}) has {len(data)} bytes, not {self.length}"
            )
        return int.from_bytes(data, "big")

    def unpack(self, data: bytes) -> dict[str, float]:
        word = self.word(data)
        return {name: signal.read(word) for name, signal in self.signals.items()}


def _signal(signal: cantools.database.can.Signal, length: int, file: str) -> SignalLayout:
    if signal.byte_order != "big_endian" or signal.offset != 0:
        raise FrameError(f"{file}: {signal.name} must be big-endian without an offset")
    if signal.minimum is None or signal.maximum is None:
        raise FrameError(f"{file}: {signal.name} must declare its range")
    first_bit = 8 * (signal.start // 8) + 7 - signal.start % 8
    mask = (1 << signal.length) - 1
    scale = float(signal.scale)
    return SignalLayout(
        signal.name,
        8 * length - first_bit - signal.length,
        mask,
        signal.is_signed,
        scale,
        round(float(signal.minimum) / scale),
        round(float(signal.maximum) / scale),
    )


@cache
def layouts(file: str = PACMOD) -> dict[str, MessageLayout]:
    """Every message of one of our DBC files by name."""
    database = cantools.database.can.Database()
    database.add_dbc_file(DBC_PATH.with_name(file))
    return {
        message.name: MessageLayout(
            message.name,
            message.frame_id,
            message.length,
            {signal.name: _signal(signal, message.length, file) for signal in message.signals},
        )
        for message in database.messages
    }
