"""The bus between replicas: NATS core, fire and forget. Whoever misses a message reads the store."""

import nats
from nats.aio.client import Client
from nats.aio.subscription import Subscription as NatsFeed
from nats.errors import ConnectionClosedError, NoServersError

PENDING_MAX = 4096


class BusUnreachable(ConnectionError):
    """No NATS server answers at the address given."""


class NatsSubscription:
    def __init__(self, feed: NatsFeed) -> None:
        self._feed = feed
        self._messages = feed.messages

    def __aiter__(self) -> "NatsSubscription":
        return self

    async def __anext__(self) -> tuple[str, bytes]:
        message = await anext(self._messages)
        return _topic(message.subject), message.data

    async def close(self) -> None:
        if not self._feed._closed:
            await self._feed.unsubscribe()


class NatsBus:
    """Open one with `connect`."""

    def __init__(self, client: Client) -> None:
        self._client = client

    async def publish(self, topic: str, payload: bytes) -> None:
        await self._client.publish(_subject(topic), payload)

    async def subscribe(self, pattern: str) -> NatsSubscription:
        feed = await self._client.subscribe(_subject(pattern), pending_msgs_limit=PENDING_MAX)
        # The server knows the subscription only after a round trip; what is said later must not be missed.
        await self._client.flush()
        return NatsSubscription(feed)

    async def close(self) -> None:
        try:
            await self._client.drain()
        except ConnectionClosedError:
            return


async def connect(url: str) -> NatsBus:
    """Raises BusUnreachable."""
    try:
        client = await nats.connect(url, max_reconnect_attempts=-1, allow_reconnect=True)
    except (OSError, NoServersError) as error:
        raise BusUnreachable(
            f"no NATS server at {url} ({error}): start one, or use the in-process bus"
        ) from error
    return NatsBus(client)


def _subject(topic: str) -> str:
    """NATS divides levels by dots; ids may hold dots themselves, which become %2E."""
    return topic.replace("%", "%25").replace(".", "%2E").replace("/", ".")


def _topic(subject: str) -> str:
    return subject.replace(".", "/").replace("%2E", ".").replace("%25", "%")
