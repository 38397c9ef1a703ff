"""Live sources of bytes: datagrams, a stream from a network, a serial device. Polled, never waited for."""

import os
import socket
import stat

_DATAGRAM_BYTES_MAX = 65_535
_CHUNK_BYTES = 4_096
_CONNECT_S = 3.0
# A lidar sends a thousand datagrams a second; a reader that is late for a while must not lose them.
_RECEIVE_BUFFER_BYTES = 4 * 1024 * 1024


class ByteSourceError(Exception):
    """A source cannot be opened; the message says which and why."""


class DatagramSource:
    """UDP datagrams to a port of this machine."""

    def __init__(self, port: int, host: str = "") -> None:
        """host: the address that is listened on, all without it."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER_BYTES)
        self._socket.setblocking(False)
        try:
            self._socket.bind((host, port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise ByteSourceError(f"UDP port {port} cannot be listened on ({error})") from error

    def fileno(self) -> int:
        return self._socket.fileno()

    @property
    def port(self) -> int:
        number: int = self._socket.getsockname()[1]
        return number

    def poll(self) -> list[bytes]:
        """The datagrams since the last poll."""
        found: list[bytes] = []
        while True:
            try:
                found.append(self._socket.recv(_DATAGRAM_BYTES_MAX))
            except BlockingIOError:
                return found

    def close(self) -> None:
        self._socket.close()


class StreamSource:
    """A stream: a TCP port, or a serial device as `stty` has set it. ended: no more will come."""

    def __init__(self, descriptor: int, keep: socket.socket | None = None) -> None:
        self.ended = False
        self._descriptor, self._keep = descriptor, keep

    @classmethod
    def connected(cls, host: str, port: int) -> "StreamSource":
        """To a TCP port; ByteSourceError if nothing answers."""
        try:
            connection = socket.create_connection((host, port), timeout=_CONNECT_S)
        except (OSError, OverflowError) as error:
            raise ByteSourceError(f"{host}:{port} does not answer ({error})") from error
        connection.setblocking(False)
        return cls(connection.fileno(), connection)

    @classmethod
    def device(cls, path: str) -> "StreamSource":
        """A character device or a pipe; ByteSourceError for anything else."""
        try:
            descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
        except OSError as error:
            raise ByteSourceError(f"{path} cannot be opened ({error.strerror})") from error
        mode = os.fstat(descriptor).st_mode
        if not (stat.S_ISCHR(mode) or stat.S_ISFIFO(mode)):
            os.close(descriptor)
            raise ByteSourceError(f"{path} is no device")
        return cls(descriptor)

    def fileno(self) -> int:
        return self._descriptor

    def poll(self) -> list[bytes]:
        """The bytes since the last poll, in pieces."""
        found: list[bytes] = []
        while not self.ended:
            try:
                data = os.read(self._descriptor, _CHUNK_BYTES)
            except BlockingIOError:
                return found
            except OSError:
                # The device was taken away, or the connection broken.
                data = b""
            self.ended = not data
            if data:
                found.append(data)
        return found

    def write(self, data: bytes) -> None:
        """A short request; ByteSourceError if it cannot be sent."""
        try:
            os.write(self._descriptor, data)
        except OSError as error:
            raise ByteSourceError(f"nothing can be sent to it ({error.strerror})") from error

    def close(self) -> None:
        if self._keep is not None:
            self._keep.close()
        else:
            os.close(self._descriptor)
