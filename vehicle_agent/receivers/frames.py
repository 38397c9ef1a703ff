"""A receiver's bytes to whole messages: NMEA sentences and UBX frames, mixed as they come."""

from typing import Literal

Kind = Literal["nmea", "ubx"]

_UBX, _NMEA = b"\xb5\x62", b"$"
# Sync, class, id, length; and the two bytes of the checksum.
_UBX_HEADER, _UBX_CHECKSUM = 6, 2
_NMEA_BYTES_MAX = 256
# Longer UBX messages are raw measurements, which are not needed here, or noise that looks like a header and
# would hold back what follows.
_UBX_BYTES_MAX = 1_024


class FrameSplitter:
    """Collects bytes until messages are whole; sans I/O.

    skipped        bytes that belong to no message
    bad_checksums  UBX frames whose checksum is wrong: what follows their first byte is looked at again
    """

    def __init__(self) -> None:
        self.skipped = 0
        self.bad_checksums = 0
        self._held = bytearray()

    def add(self, data: bytes) -> list[tuple[Kind, bytes]]:
        """The messages that these bytes complete."""
        self._held += data
        found: list[tuple[Kind, bytes]] = []
        while (frame := self._next()) is not None:
            found.append(frame)
        return found

    def _next(self) -> tuple[Kind, bytes] | None:
        while self._skip_to_a_begin():
            length = self._length()
            if length is None:
                return None
            if length > 0:
                frame = bytes(self._held[:length])
                del self._held[:length]
                return ("ubx" if frame.startswith(_UBX) else "nmea"), frame
            self._drop(1)
        return None

    def _skip_to_a_begin(self) -> bool:
        """Whether something that begins like a message is at the front."""
        begins = [at for at in (self._held.find(_UBX), self._held.find(_NMEA)) if at >= 0]
        if begins:
            self._drop(min(begins))
            return True
        # The first half of a sync may be the last byte.
        self._drop(len(self._held) - (1 if self._held.endswith(_UBX[:1]) else 0))
        return False

    def _length(self) -> int | None:
        """Of the message at the front; 0 if it is none, None if it is not known yet."""
        if self._held.startswith(_UBX):
            if len(self._held) < _UBX_HEADER:
                return None
            length = _UBX_HEADER + int.from_bytes(self._held[4:6], "little") + _UBX_CHECKSUM
            if length > _UBX_BYTES_MAX:
                return 0
            if len(self._held) < length:
                return None
            if _checksum(self._held[2 : length - 2]) != self._held[length - 2 : length]:
                self.bad_checksums += 1
                return 0
            return length
        end = self._held.find(b"\n", 0, _NMEA_BYTES_MAX)
        whole = end >= 0
        if not self._held[: end if whole else _NMEA_BYTES_MAX].isascii():
            return 0
        if whole:
            return end + 1
        return None if len(self._held) < _NMEA_BYTES_MAX else 0

    def _drop(self, count: int) -> None:
        self.skipped += count
        del self._held[:count]


def _checksum(data: bytearray) -> bytes:
    """Fletcher's of eight bits, over class, id, length and payload (u-blox interface description, 3.4)."""
    a = b = 0
    for byte in data:
        a = (a + byte) & 0xFF
        b = (b + a) & 0xFF
    return bytes((a, b))
