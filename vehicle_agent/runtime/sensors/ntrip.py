"""Corrections from an NTRIP caster, revisions 1 and 2 (RTCM 10410.1); sans I/O."""

import base64
from datetime import UTC, datetime
from urllib.parse import urlsplit

import msgspec

from vehicle_agent.receivers.solutions import Solution

_HEADER_BYTES_MAX = 8_192
_CHUNK_LINE_BYTES_MAX = 64


class NtripRefused(Exception):
    """The caster gives no corrections; the message says what it answered."""


class Caster(msgspec.Struct, frozen=True):
    """A mountpoint of a caster."""

    host: str
    port: int
    mountpoint: str
    is_encrypted: bool
    user: str = ""
    password: str = ""


def caster_of(url: str, user: str = "", password: str = "") -> Caster:
    """Raises ValueError for a URL that names no mountpoint."""
    parts = urlsplit(url)
    mountpoint = parts.path.strip("/")
    if parts.scheme not in ("http", "https") or not parts.hostname or not mountpoint or "/" in mountpoint:
        raise ValueError(f"{url!r} is no http(s)://HOST:PORT/MOUNTPOINT")
    if parts.username or parts.password:
        raise ValueError("corrections: give user and password_file instead of a password in the URL")
    default_port = 443 if parts.scheme == "https" else 2101
    return Caster(
        parts.hostname, parts.port or default_port, mountpoint, parts.scheme == "https", user, password
    )


class NtripSession:
    """One connection: the request, and the corrections in what comes back.

    has_begun  the caster has said yes
    """

    def __init__(self, caster: Caster) -> None:
        self._caster = caster
        self._held = bytearray()
        self.has_begun = False
        self._is_chunked = False
        self._chunk_left = 0

    def request(self) -> bytes:
        caster = self._caster
        lines = [
            f"GET /{caster.mountpoint} HTTP/1.1",
            f"Host: {caster.host}:{caster.port}",
            "Ntrip-Version: Ntrip/2.0",
            "User-Agent: NTRIP campusloop/1.0",
            "Connection: close",
        ]
        if caster.user:
            secret = base64.b64encode(f"{caster.user}:{caster.password}".encode()).decode()
            lines.append(f"Authorization: Basic {secret}")
        return ("\r\n".join(lines) + "\r\n\r\n").encode()

    def add(self, data: bytes) -> bytes:
        """The corrections in these bytes. Raises NtripRefused."""
        self._held += data
        if not self.has_begun and not self._begin():
            return b""
        return self._dechunked() if self._is_chunked else self._all()

    def _begin(self) -> bool:
        """Whether the caster's header is there, and says yes."""
        first, separator, _ = bytes(self._held).partition(b"\r\n")
        if separator and first.startswith(b"ICY 200"):
            # Revision 1 has no header fields; some casters send an empty line, which no receiver minds.
            del self._held[: len(first) + 2]
            self.has_begun = True
            return True
        if separator and not first.startswith(b"HTTP/"):
            raise NtripRefused(_said(self._caster, first))
        head, separator, _ = bytes(self._held).partition(b"\r\n\r\n")
        if not separator:
            if len(self._held) > _HEADER_BYTES_MAX:
                raise NtripRefused(f"{self._caster.host} answers with something that is no header")
            return False
        status, *fields = head.split(b"\r\n")
        if status.split(b" ")[1:2] != [b"200"]:
            raise NtripRefused(_said(self._caster, status))
        split = (field.partition(b":") for field in fields)
        names = {name.strip().lower(): value.strip().lower() for name, _, value in split}
        if names.get(b"content-type", b"").startswith((b"gnss/sourcetable", b"text/")):
            raise NtripRefused(_said(self._caster, b"SOURCETABLE"))
        self._is_chunked = names.get(b"transfer-encoding") == b"chunked"
        del self._held[: len(head) + 4]
        self.has_begun = True
        return True

    def _all(self) -> bytes:
        found = bytes(self._held)
        self._held.clear()
        return found

    def _dechunked(self) -> bytes:
        found = b""
        while self._held:
            if self._chunk_left == 0:
                line, separator, _ = bytes(self._held[:_CHUNK_LINE_BYTES_MAX]).partition(b"\r\n")
                if not separator:
                    if len(self._held) >= _CHUNK_LINE_BYTES_MAX:
                        raise NtripRefused(f"{self._caster.host} sends chunks without their length")
                    break
                del self._held[: len(line) + 2]
                if not line:
                    # The end of the chunk before.
                    continue
                try:
                    self._chunk_left = int(line.split(b";")[0], 16)
                except ValueError as error:
                    raise NtripRefused(f"{self._caster.host} sends a chunk of length {line!r}") from error
                continue
            part = bytes(self._held[: self._chunk_left])
            del self._held[: len(part)]
            self._chunk_left -= len(part)
            found += part
        return found


def _said(caster: Caster, answer: bytes) -> str:
    text = answer.decode("latin-1").strip()
    if text.startswith("SOURCETABLE"):
        return f"{caster.host} has no mountpoint {caster.mountpoint!r}"
    if "401" in text:
        return f"{caster.host} refuses user and password ({text})"
    return f"{caster.host} answers {text[:100]!r}"


def gga_sentence(solution: Solution, now_utc_ns: int) -> bytes:
    """Where the vehicle is, as casters of virtual reference stations ask for it (NMEA 0183, GGA)."""
    time = datetime.fromtimestamp(now_utc_ns / 1e9, tz=UTC)
    body = (
        f"GPGGA,{time:%H%M%S}.00,{_angle(solution.latitude_deg, 2)},{'NS'[solution.latitude_deg < 0.0]},"
        f"{_angle(solution.longitude_deg, 3)},{'EW'[solution.longitude_deg < 0.0]},1,12,1.0,0.0,M,0.0,M,,"
    )
    checksum = 0
    for byte in body.encode():
        checksum ^= byte
    return f"${body}*{checksum:02X}\r\n".encode()


def _angle(degrees: float, digits: int) -> str:
    """Degrees and minutes: ddmm.mmmmm."""
    # Rounded at once, so that no minute is 60.
    minutes = round(abs(degrees) * 60.0, 5)
    whole = int(minutes // 60.0)
    return f"{whole:0{digits}d}{minutes - 60.0 * whole:08.5f}"
