"""How a sensor is reached: a serial device, a TCP port, or UDP to a port of this computer."""

import termios
from typing import Literal

import msgspec


class AddressError(ValueError):
    """An address of no form; the message says what forms there are."""


class Address(msgspec.Struct, frozen=True):
    """kind "device": path and baud (0: as it is set); "tcp": host and port; "udp": port."""

    kind: Literal["device", "tcp", "udp"]
    path: str = ""
    baud: int = 0
    host: str = ""
    port: int = 0


def address_of(name: str, text: str, baud: int = 0) -> Address:
    """Raises AddressError."""
    if text.startswith("/"):
        if baud and baud not in BAUDS:
            raise AddressError(f"{name}: {baud} baud; there are: {', '.join(map(str, sorted(BAUDS)))}")
        return Address("device", path=text, baud=baud)
    match text.split(":"):
        case ["udp", port] if _is_port(port):
            return Address("udp", port=int(port))
        case ["tcp", host, port] if host and _is_port(port):
            return Address("tcp", host=host, port=int(port))
    raise AddressError(f"{name}: {text!r} is none of /dev/NAME, tcp:HOST:PORT, udp:PORT")


def _is_port(text: str) -> bool:
    return text.isdecimal() and 0 < int(text) < 65_536


BAUDS = {
    baud: getattr(termios, f"B{baud}")
    for baud in (9600, 19_200, 38_400, 57_600, 115_200, 230_400, 460_800, 921_600)
}
