"""A TCP relay before the server, which a fault makes worse than a network should be."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

_REFUSAL = b"HTTP/1.1 502 Bad Gateway\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
_DRIP_EVERY_S = 0.001


class Relay:
    """Forwards connections to `port`.

    is_frozen  nothing is forwarded and nothing closed, as by a NAT that has forgotten the connection
    refuses    new connections get the answer of a proxy without a server
    drips      bytes to the server go one by one
    """

    def __init__(self, port: int) -> None:
        self.port = 0
        self.is_frozen = self.refuses = self.drips = False
        self.connections = self.refused = 0
        self._to = port
        self._tasks: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        server = await asyncio.start_server(self._accepted, "127.0.0.1", 0)
        self.port = server.sockets[0].getsockname()[1]
        try:
            await server.serve_forever()
        finally:
            for task in list(self._tasks):
                task.cancel()
            await asyncio.gather(*self._tasks, return_exceptions=True)

    def _accepted(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.get_running_loop().create_task(self._relay(reader, writer))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _relay(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.connections += 1
        if self.refuses:
            self.refused += 1
            await reader.readuntil(b"\r\n\r\n")
            writer.write(_REFUSAL)
            await writer.drain()
            writer.close()
            return
        there, back = await asyncio.open_connection("127.0.0.1", self._to)
        ways = (self._forward(reader, back, drips=True), self._forward(there, writer, drips=False))
        tasks = [asyncio.create_task(way) for way in ways]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            writer.close()
            back.close()

    async def _forward(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, *, drips: bool
    ) -> None:
        while data := await reader.read(65_536):
            if self.is_frozen:
                await asyncio.Event().wait()
            if drips and self.drips:
                for byte in data:
                    writer.write(bytes((byte,)))
                    await writer.drain()
                    await asyncio.sleep(_DRIP_EVERY_S)
            else:
                writer.write(data)
                await writer.drain()
        if self.is_frozen:
            # Nor is an end passed on.
            await asyncio.Event().wait()


@asynccontextmanager
async def a_relay(port: int) -> AsyncIterator[Relay]:
    relay = Relay(port)
    running = asyncio.create_task(relay.run())
    try:
        async with asyncio.timeout(10.0):
            while not relay.port:  # noqa: ASYNC110 - the operating system gives it
                await asyncio.sleep(0.01)
        yield relay
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
