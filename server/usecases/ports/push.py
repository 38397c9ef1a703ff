"""Sending messages to browsers, by the push services of their makers."""

from dataclasses import dataclass
from datetime import datetime
from typing import Protocol

from server.domain.rides.notices import PushSubscription


@dataclass(frozen=True, slots=True)
class PushMessage:
    """content  what the page's service worker gets, as JSON
    ttl_s    how long the push service keeps it for a phone that is out of reach
    topic    a later message of the same topic replaces one that has not arrived: 32 characters at most
    """

    content: bytes
    ttl_s: int
    topic: str


@dataclass(frozen=True, slots=True)
class PushAnswer:
    """failure  why it did not arrive, without the address; empty if the push service has it
    is_gone  it never will: the browser has withdrawn the subscription, or its keys are none
    """

    failure: str = ""
    is_gone: bool = False


class PushSender(Protocol):
    @property
    def public_key(self) -> str:
        """What browsers subscribe with."""
        ...

    async def send(self, subscription: PushSubscription, message: PushMessage, at: datetime) -> PushAnswer:
        """One attempt, within a limited time. It raises nothing that the push service or network causes."""
        ...
