"""The bus between replicas: NATS core. Messages may be lost; the store has the facts."""

import structlog
from nats.aio.client import Client
from nats.aio.subscription import Subscription as NatsFeed
from nats.errors import BadSubscriptionError, ConnectionClosedError, NoServersError
from nats.errors import Error as NatsError
from nats.errors import TimeoutError as NatsTimeout

log = structlog.get_logger("bus")

PENDING_MAX = 4096
FIRST_ATTEMPTS = 3
FLUSH_WITHIN_S = 2


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
        """The reader ends. Draining would wait for ever for what a cancelled reader has left."""
        try:
            await self._feed.unsubscribe()
        except (ConnectionClosedError, BadSubscriptionError):
            return


class NatsBus:
    """Open one with `connect`."""

    def __init__(self, client: Client) -> None:
        self._client = client

    async def publish(self, topic: str, payload: bytes) -> None:
        """A message that cannot be sent now is lost, as any message on a bus may be; the log says so."""
        try:
            await self._client.publish(_subject(topic), payload)
        except NatsError as error:
            log.warning("bus.message_lost", topic=topic, cause=str(error) or type(error).__name__)

    def wants(self, topic: str) -> bool:
        """Other replicas may read it."""
        return True

    async def subscribe(self, pattern: str) -> NatsSubscription:
        feed = await self._client.subscribe(_subject(pattern), pending_msgs_limit=PENDING_MAX)
        # The server knows the subscription only after a round trip; a later message must not be missed.
        await self._client.flush()
        return NatsSubscription(feed)

    async def close(self) -> None:
        """What was published is sent first, if the server is within reach."""
        if self._client.is_connected:
            try:
                await self._client.flush(FLUSH_WITHIN_S)
            except NatsError as error:
                log.warning("bus.not_flushed", cause=str(error) or type(error).__name__)
        await self._client.close()


async def connect(url: str) -> NatsBus:
    """Raises BusUnreachable if no server answers at first. After a later cut the client reconnects."""
    client = Client()
    try:
        await client.connect(url, max_reconnect_attempts=FIRST_ATTEMPTS, reconnect_time_wait=1)
    except (OSError, NoServersError, NatsTimeout) as error:
        raise BusUnreachable(
            f"no NATS server at {url} ({error}): start one, or use the in-process bus"
        ) from error
    client.options["max_reconnect_attempts"] = -1
    return NatsBus(client)


def _subject(topic: str) -> str:
    """NATS divides levels by dots; ids may hold dots themselves, which become %2E."""
    return topic.replace("%", "%25").replace(".", "%2E").replace("/", ".")


def _topic(subject: str) -> str:
    return subject.replace(".", "/").replace("%2E", ".").replace("%25", "%")
