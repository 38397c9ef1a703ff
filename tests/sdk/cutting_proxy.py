"""A TCP proxy whose connections can be cut, and which can lose the server's answers."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from urllib.parse import urlsplit


class CuttingProxy:
    """answers_to_lose: that many connections end when the server begins to answer."""

    def __init__(self, target: str) -> None:
        self._target = urlsplit(target)
        self._open: set[asyncio.StreamWriter] = set()
        self.answers_to_lose = 0
        self.connections = 0
        self.is_shut = False
        self.origin = ""

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self.is_shut:
            writer.close()
            return
        self.connections += 1
        upstream, to_server = await asyncio.open_connection(self._target.hostname, self._target.port)
        self._open |= {writer, to_server}
        loop = asyncio.get_running_loop()
        both = (
            loop.create_task(self._pump(reader, to_server)),
            loop.create_task(self._pump(upstream, writer, is_answer=True)),
        )
        try:
            await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in both:
                task.cancel()
            for end in (writer, to_server):
                self._open.discard(end)
                end.close()

    async def _pump(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, is_answer: bool = False
    ) -> None:
        while data := await reader.read(65_536):
            if is_answer and self.answers_to_lose:
                self.answers_to_lose -= 1
                return
            writer.write(data)
            await writer.drain()

    def cut(self) -> None:
        """Every connection ends now, without a closing frame."""
        for writer in self._open:
            writer.transport.abort()


@asynccontextmanager
async def cutting_proxy(target: str) -> AsyncIterator[CuttingProxy]:
    proxy = CuttingProxy(target)
    server = await asyncio.start_server(proxy.serve, "127.0.0.1", 0)
    proxy.origin = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
    try:
        yield proxy
    finally:
        server.close()
        proxy.cut()
