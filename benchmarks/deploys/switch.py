"""A TCP switch before the replicas, as a proxy with health checks is one: a process of its own.

    python -m benchmarks.deploys.switch PORT REPLICA_PORT ...

Each new connection goes to the replica that is ready and has the fewest. One that refuses it is passed over.
While none takes it, it waits.
"""

import asyncio
import sys
from dataclasses import dataclass
from typing import cast

import uvloop

_ASKED_EVERY_S = 0.5
_ANSWERS_WITHIN_S = 2.0
_TRIED_FOR_S = 5.0
_TRIED_EVERY_S = 0.1
_READY = b"GET /api/v1/ready HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"


@dataclass
class _Replica:
    port: int
    is_ready: bool = False
    connections: int = 0


class _Pipe(asyncio.Protocol):
    """One end of a switched connection. What comes before the other end is there waits."""

    def __init__(self, other: "_Pipe | None" = None) -> None:
        self.other = other
        self.transport: asyncio.Transport | None = None
        self.begun = bytearray()
        self.ended = asyncio.get_running_loop().create_future()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast(asyncio.Transport, transport)

    def data_received(self, data: bytes) -> None:
        if self.other is None or self.other.transport is None:
            self.begun += data
        else:
            self.other.transport.write(data)

    def connection_lost(self, exc: Exception | None) -> None:
        if not self.ended.done():
            self.ended.set_result(None)
        if self.other is not None and self.other.transport is not None:
            self.other.transport.close()


class Switch:
    def __init__(self, ports: list[int]) -> None:
        self._replicas = [_Replica(port) for port in ports]
        self._tasks: set[asyncio.Task[None]] = set()

    async def run(self, port: int) -> None:
        loop = asyncio.get_running_loop()
        server = await loop.create_server(self._accepted, "127.0.0.1", port, backlog=1024)
        print("listens", flush=True)
        await asyncio.gather(server.serve_forever(), *(self._ask(replica) for replica in self._replicas))

    def _accepted(self) -> _Pipe:
        client = _Pipe()
        task = asyncio.get_running_loop().create_task(self._join(client))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return client

    async def _join(self, client: _Pipe) -> None:
        """Lead the connection to a replica until it ends."""
        replica, server = await self._dial(client)
        if server is None or replica is None:
            if client.transport is not None:
                client.transport.abort()
            return
        replica.connections += 1
        try:
            client.other = server
            assert server.transport is not None
            server.transport.write(bytes(client.begun))
            if client.ended.done():
                server.transport.close()
            await server.ended
        finally:
            replica.connections -= 1

    async def _dial(self, client: _Pipe) -> tuple[_Replica | None, _Pipe | None]:
        loop = asyncio.get_running_loop()
        until_s = loop.time() + _TRIED_FOR_S
        while loop.time() < until_s and not client.ended.done():
            for replica in sorted(self._replicas, key=lambda one: (not one.is_ready, one.connections)):
                if not replica.is_ready:
                    break
                try:
                    _, server = await loop.create_connection(lambda: _Pipe(client), "127.0.0.1", replica.port)
                    return replica, server
                except OSError:
                    replica.is_ready = False
            await asyncio.sleep(_TRIED_EVERY_S)
        return None, None

    async def _ask(self, replica: _Replica) -> None:
        while True:
            try:
                async with asyncio.timeout(_ANSWERS_WITHIN_S):
                    reader, writer = await asyncio.open_connection("127.0.0.1", replica.port)
                    writer.write(_READY)
                    replica.is_ready = b" 200 " in await reader.readline()
                    writer.close()
            except (OSError, TimeoutError):
                replica.is_ready = False
            await asyncio.sleep(_ASKED_EVERY_S)


if __name__ == "__main__":
    with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
        runner.run(Switch([int(port) for port in sys.argv[2:]]).run(int(sys.argv[1])))
