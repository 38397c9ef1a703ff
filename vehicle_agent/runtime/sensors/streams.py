"""Streams of receivers: opened, read and written without waiting for each other, and opened again."""

import asyncio
import os
import stat
import termios
from typing import Protocol

from vehicle_agent.runtime.sensors.addresses import BAUDS, Address

CONNECT_S = 5.0
_CHUNK_BYTES = 4_096
# Datagrams that wait for their reader; a receiver sends some tens in a second.
_WAITING_MAX = 1_000
_HOST = "0.0.0.0"


class Stream(Protocol):
    """An open stream of bytes."""

    async def read(self) -> bytes:
        """The next bytes; b"" at the end. Raises OSError."""
        ...

    async def write(self, data: bytes) -> None:
        """Raises OSError."""
        ...

    def close(self) -> None: ...


async def open_stream(address: Address) -> Stream:
    """Raises OSError, also where nothing answers in time."""
    if address.kind == "device":
        return _Device(address)
    if address.kind == "udp":
        return await _Datagrams.listening(address.port)
    async with asyncio.timeout(CONNECT_S):
        return _Connection(*await asyncio.open_connection(address.host, address.port))


class _Connection:
    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader, self._writer = reader, writer

    async def read(self) -> bytes:
        return await self._reader.read(_CHUNK_BYTES)

    async def write(self, data: bytes) -> None:
        self._writer.write(data)
        await self._writer.drain()

    def close(self) -> None:
        self._writer.close()


class _Device:
    """A serial device, raw: eight bits, no parity, nothing translated or echoed."""

    def __init__(self, address: Address) -> None:
        self._file = os.open(address.path, os.O_RDWR | os.O_NONBLOCK | os.O_NOCTTY)
        try:
            if not stat.S_ISCHR(os.fstat(self._file).st_mode):
                raise OSError(f"{address.path} is no device")
            set_raw(self._file, address.baud)
        except termios.error as error:
            os.close(self._file)
            raise OSError(f"{address.path} is no serial device ({error})") from error
        except OSError:
            os.close(self._file)
            raise

    async def read(self) -> bytes:
        loop = asyncio.get_running_loop()
        while True:
            ready = asyncio.Event()
            loop.add_reader(self._file, ready.set)
            try:
                await ready.wait()
            finally:
                loop.remove_reader(self._file)
            try:
                return os.read(self._file, _CHUNK_BYTES)
            except BlockingIOError:
                continue

    async def write(self, data: bytes) -> None:
        loop = asyncio.get_running_loop()
        while data:
            ready = asyncio.Event()
            loop.add_writer(self._file, ready.set)
            try:
                await ready.wait()
            finally:
                loop.remove_writer(self._file)
            try:
                data = data[os.write(self._file, data) :]
            except BlockingIOError:
                continue

    def close(self) -> None:
        os.close(self._file)


def set_raw(file: int, baud: int) -> None:
    """As cfmakeraw of termios(3). baud 0: as it is set. Raises termios.error for what is no serial line."""
    iflag, oflag, cflag, lflag, ispeed, ospeed, cc = termios.tcgetattr(file)
    iflag &= ~(
        termios.IGNBRK | termios.BRKINT | termios.PARMRK | termios.ISTRIP | termios.INLCR | termios.IGNCR
        | termios.ICRNL | termios.IXON
    )  # fmt: skip
    oflag &= ~termios.OPOST
    lflag &= ~(termios.ECHO | termios.ECHONL | termios.ICANON | termios.ISIG | termios.IEXTEN)
    cflag = cflag & ~(termios.CSIZE | termios.PARENB) | termios.CS8 | termios.CREAD | termios.CLOCAL
    cc[termios.VMIN], cc[termios.VTIME] = 1, 0
    if baud:
        ispeed = ospeed = BAUDS[baud]
    termios.tcsetattr(file, termios.TCSANOW, [iflag, oflag, cflag, lflag, ispeed, ospeed, cc])


class _Datagrams(asyncio.DatagramProtocol):
    """UDP to a port of this computer. A reader that is late loses the newest."""

    def __init__(self) -> None:
        self._waiting: asyncio.Queue[bytes] = asyncio.Queue(_WAITING_MAX)
        self._transport: asyncio.BaseTransport | None = None

    @classmethod
    async def listening(cls, port: int) -> "_Datagrams":
        loop = asyncio.get_running_loop()
        transport, protocol = await loop.create_datagram_endpoint(cls, local_addr=(_HOST, port))
        protocol._transport = transport
        return protocol

    def datagram_received(self, data: bytes, addr: object) -> None:
        if not self._waiting.full():
            self._waiting.put_nowait(data)

    async def read(self) -> bytes:
        return await self._waiting.get()

    async def write(self, data: bytes) -> None:
        raise OSError("a receiver that sends datagrams cannot be written to")

    def close(self) -> None:
        assert self._transport is not None
        self._transport.close()
