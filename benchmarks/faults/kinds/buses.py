"""The NATS server between replicas: away, frozen, flooded, or full of nonsense."""

import asyncio
import signal

from nats.aio.client import Client

from benchmarks.faults.stage import Stage

_AWAY_S = 4.0
_FROZEN_S = 10.0
_FLOOD = 6_000
_FLOOD_BYTES = 60_000


async def broker_killed(stage: Stage) -> None:
    """SIGKILL twice; it is away for 4 s each time."""
    for _ in range(2):
        await asyncio.to_thread(stage.broker.kill)
        await asyncio.sleep(_AWAY_S)
        await asyncio.to_thread(stage.broker.start)
        await asyncio.sleep(2.0)


async def broker_frozen(stage: Stage) -> None:
    """SIGSTOP for 10 s: the connection is open and nothing moves."""
    stage.broker.process.send_signal(signal.SIGSTOP)
    await asyncio.sleep(_FROZEN_S)
    stage.broker.process.send_signal(signal.SIGCONT)


async def slow_consumer(stage: Stage) -> None:
    """The server is stopped while 360 MB of messages come: the broker gives it up as too slow."""
    client = await _client(stage)
    topic = f"campus.{stage.network.road_map.campus_id}.service"
    stage.installation.kill(signal.SIGSTOP)
    try:
        for _ in range(_FLOOD):
            await client.publish(topic, b"{}" + b" " * _FLOOD_BYTES)
        await client.flush(30)
    finally:
        stage.installation.kill(signal.SIGCONT)
        await client.close()


async def nonsense_on_the_bus(stage: Stage) -> None:
    """A stranger publishes what is no message on every topic of the campus."""
    client = await _client(stage)
    campus = f"campus.{stage.network.road_map.campus_id}"
    names = ("outbox", "session", "state", "status", "live", "event")
    topics = [f"{campus}.vehicle.shuttle-1.{name}" for name in names]
    topics += [f"{campus}.{name}" for name in ("dispatch", "sections", "service", "closures", "map")]
    topics += [f"{campus}.area.a1.presence", f"{campus}.ride.r1", f"{campus}.series.s1"]
    for payload in (b"", b"{", b"\xff", b"[]", b'{"epoch":"x"}', b'{"type":"teleport"}', b"[" * 5_000):
        for topic in topics:
            await client.publish(topic, payload)
    await client.flush(10)
    await client.close()


async def _client(stage: Stage) -> Client:
    client = Client()
    await client.connect(stage.broker.url)
    return client
