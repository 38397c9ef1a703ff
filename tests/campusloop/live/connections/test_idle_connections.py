"""A client that says nothing for a while, as a script that looks every few seconds."""

import asyncio
from pathlib import Path
from urllib.parse import urlsplit

from tests.campusloop.live.live_server import live_server

# For longer than httpx and many others keep theirs: the client has to be the one that closes.
IDLE_S = 6.0
ASKED = b"GET /api/v1/health HTTP/1.1\r\nhost: 127.0.0.1\r\n\r\n"


def test_a_connection_that_was_idle_answers_the_next_request(tmp_path: Path) -> None:
    async def scenario() -> None:
        async with live_server(tmp_path) as server:
            reader, writer = await asyncio.open_connection("127.0.0.1", urlsplit(server.origin).port)
            for idle_s in (IDLE_S, 0.0):
                writer.write(ASKED)
                async with asyncio.timeout(30):
                    head = (await reader.readuntil(b"\r\n\r\n")).lower()
                    assert head.startswith(b"http/1.1 200")
                    await reader.readexactly(int(head.split(b"content-length: ")[1].split(b"\r\n")[0]))
                await asyncio.sleep(idle_s)
            writer.close()

    asyncio.run(scenario())
