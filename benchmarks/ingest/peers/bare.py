"""A bare websocket server: it reads each frame and answers it with a fixed acknowledgement, and does
nothing else.

    python -m benchmarks.ingest.peers.bare PORT

The library `websockets` on uvloop, without compression: what the frames alone cost in Python.
"""

import sys

import uvloop
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

_NEXT = '"sequence":'


async def _converse(connection: ServerConnection) -> None:
    try:
        async for frame in connection:
            # The load generator waits for its numbers, so the one in the frame is found and no more is read.
            assert isinstance(frame, str)
            at = frame.index(_NEXT) + len(_NEXT)
            number = int(frame[at : frame.index(",", at)])
            await connection.send(f'{{"type":"events_acknowledged","next_sequence":{number + 1}}}')
    except ConnectionClosed:
        return


async def _serve(port: int) -> None:
    async with serve(_converse, "127.0.0.1", port, compression=None) as server:
        await server.serve_forever()


if __name__ == "__main__":
    uvloop.run(_serve(int(sys.argv[1])))
