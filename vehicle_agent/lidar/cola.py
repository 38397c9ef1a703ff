"""Telegrams of SICK's planar scanners (LMS1xx, TiM5xx and kin): bytes in, turns of the mirror out; sans I/O.

SICK, "Telegram Listing" 8014631: CoLa A is text between STX and ETX; numbers are hexadecimal, or decimal
with a sign. `LMDscandata` has one turn, and `sEN LMDscandata 1` asks for all turns from now on.
"""

import math
import struct
from collections.abc import Iterator
from typing import NamedTuple

import msgspec
import numpy as np

from contract.geometry import Array

START_TURNS = b"\x02sEN LMDscandata 1\x03"
_STX, _ETX = b"\x02", b"\x03"
# A turn of 1,081 beams with two echoes and their intensities has about 20 kB.
_TELEGRAM_BYTES_MAX = 65_536
_BEAMS_MAX = 10_000
# Smaller raw distances are codes for what was not measured.
_RAW_MIN = 16
# Of the scanner's angles, which count from its right, the one ahead.
_AHEAD_RAD = 0.5 * math.pi
_UNIT_RAD = math.radians(1e-4)
_STATUS = {0: "", 1: "device error", 2: "pollution warning", 4: "pollution", 5: "pollution"}


class TelegramError(Exception):
    """A telegram that is not understood; code says why."""

    def __init__(self, code: str) -> None:
        super().__init__(code)
        self.code = code


class ScannerRefusal(TelegramError):
    """The scanner refuses to send turns; code holds its number."""


class PlanarTurn(msgspec.Struct, frozen=True, eq=False):
    """One turn of a planar scanner.

    counter      of the turns that were sent, 16 bits
    age_s        from the turn's zero until it was sent, by the scanner's clock
    ranges_m     (n,) inf where nothing returned
    angles_rad   (n,) from straight ahead of the scanner, left positive
    intensities  (n,) 0 where the scanner sends none
    offsets_s    (n,) of each beam after the one in the middle
    status       what the scanner says is wrong with it; empty: nothing
    """

    counter: int
    age_s: float
    ranges_m: Array
    angles_rad: Array
    intensities: Array
    offsets_s: Array
    status: str


class TelegramReader:
    """Bytes of a stream to the telegrams between STX and ETX; `refused` counts what was none, by code."""

    def __init__(self) -> None:
        self.refused: dict[str, int] = {}
        self._held = b""

    def add(self, data: bytes) -> list[bytes]:
        """The telegrams that these bytes complete."""
        found = []
        *whole, self._held = (self._held + data).split(_ETX)
        for part in whole:
            noise, begun, telegram = part.rpartition(_STX)
            if noise or not begun:
                self.refuse("noise")
            if begun:
                found.append(telegram)
        if len(self._held) > _TELEGRAM_BYTES_MAX:
            self.refuse("no_end")
            self._held = b""
        return found

    def refuse(self, code: str) -> None:
        self.refused[code] = self.refused.get(code, 0) + 1


def turn_of(telegram: bytes) -> PlanarTurn | None:
    """The turn of a telegram; None for another good one. Raises TelegramError."""
    words = telegram.split()
    if words[:1] == [b"sFA"]:
        raise ScannerRefusal(f"sFA {words[1].decode('ascii', 'replace') if len(words) > 1 else ''}".strip())
    if words[1:2] != [b"LMDscandata"] or words[0] not in (b"sSN", b"sRA"):
        return None
    reading = _Words(words[2:])
    try:
        return _turn(reading)
    except (ValueError, struct.error, OverflowError) as error:
        raise TelegramError("bad_number") from error


class _Channel(NamedTuple):
    """raw (n,) as sent; values: scaled; start and step, rad."""

    raw: Array
    values: Array
    start_rad: float
    step_rad: float


def _turn(words: "_Words") -> PlanarTurn:
    words.skip(3)  # version, device, serial number
    words.skip(1)
    status = words.number()
    counter = words.number()
    words.skip(1)  # turns, sent or not
    begun_us, sent_us = words.number(), words.number()
    words.skip(5)  # inputs, outputs, reserved
    turns_hz = 0.01 * words.number()
    words.skip(1)
    words.skip(2 * words.number())  # encoders
    channels = dict(_channels(words)) | dict(_channels(words))
    distances = channels.get("DIST1")
    if distances is None:
        raise TelegramError("no_distances")
    count = len(distances.raw)
    angles = distances.start_rad + distances.step_rad * np.arange(count, dtype=np.float64) - _AHEAD_RAD
    if not (count > 0 and distances.step_rad > 0.0 and 0.0 < turns_hz <= 1_000.0):
        raise TelegramError("bad_geometry")
    if np.abs(angles).max() > 2.0 * math.pi:
        raise TelegramError("bad_geometry")
    intensities = channels.get("RSSI1")
    ranges = np.where(distances.raw >= _RAW_MIN, 1e-3 * distances.values, np.inf)
    if not (ranges > 0.0).all():
        raise TelegramError("bad_number")
    return PlanarTurn(
        counter=counter,
        age_s=1e-6 * ((sent_us - begun_us) % (1 << 32)),
        ranges_m=ranges,
        angles_rad=angles,
        intensities=(
            intensities.values
            if intensities is not None and len(intensities.values) == count
            else np.zeros(count)
        ),
        offsets_s=(angles - 0.5 * (angles[0] + angles[-1])) / (2.0 * math.pi * turns_hz),
        status=_STATUS.get(status, f"status {status}"),
    )


def _channels(words: "_Words") -> Iterator[tuple[str, _Channel]]:
    """The channels of one width, by name."""
    for _ in range(words.number()):
        name = words.text()
        scale, offset = words.real(), words.real()
        start, step, count = words.number(), words.number(), words.number()
        if count > _BEAMS_MAX:
            raise TelegramError("bad_geometry")
        # Of 32 bits, with a sign.
        start = (start + (1 << 31)) % (1 << 32) - (1 << 31)
        raw = np.array([words.number() for _ in range(count)], dtype=np.float64)
        yield name, _Channel(raw, scale * raw + offset, _UNIT_RAD * start, _UNIT_RAD * step)


class _Words:
    """A telegram's words, one after the other."""

    def __init__(self, words: list[bytes]) -> None:
        self._words = iter(words)

    def skip(self, count: int) -> None:
        for _ in range(count):
            self._next()

    def text(self) -> str:
        return self._next().decode("ascii")

    def number(self) -> int:
        """Hexadecimal without a sign, decimal with one."""
        word = self._next()
        return int(word, 10 if word[:1] in (b"+", b"-") else 16)

    def real(self) -> float:
        """A 32-bit float as its eight digits; an ASCII decimal with a sign, too."""
        word = self._next()
        if word[:1] in (b"+", b"-"):
            value = float(word)
        else:
            value = struct.unpack(">f", int(word, 16).to_bytes(4, "big"))[0]
        if not math.isfinite(value):
            raise ValueError(word)
        return value

    def _next(self) -> bytes:
        word = next(self._words, None)
        if word is None:
            raise TelegramError("cut_short")
        return word
