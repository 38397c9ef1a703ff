"""Sends messages to browsers by their push services (RFC 8030), to public addresses only as webhooks do."""

import secrets
from collections.abc import Mapping
from datetime import datetime
from typing import Protocol
from urllib.parse import urlsplit

from server.domain.rides.notices import PushSubscription
from server.push_encryption import (
    SALT_BYTES,
    BrowserKeys,
    PushIdentity,
    encrypted,
    from_base64url,
    new_message_key,
)
from server.usecases.ports.push import PushAnswer, PushMessage
from server.usecases.ports.webhooks import WebhookAnswer

# The browser has withdrawn the subscription, or never made it (RFC 8030, 7.3).
GONE = (404, 410)


class HttpSender(Protocol):
    """Sends by HTTP, to addresses that it may reach: `HttpWebhookSender`."""

    async def send(self, url: str, headers: Mapping[str, str], body: bytes) -> WebhookAnswer: ...


class WebPushSender:
    """contact: `mailto:` or `https:` of those who run the server, for push services; "" for none."""

    def __init__(self, identity: PushIdentity, http: HttpSender, contact: str = "") -> None:
        self._identity, self._http, self._contact = identity, http, contact

    @property
    def public_key(self) -> str:
        return self._identity.public_key

    async def send(self, subscription: PushSubscription, message: PushMessage, at: datetime) -> PushAnswer:
        try:
            keys = BrowserKeys(from_base64url(subscription.p256dh), from_base64url(subscription.auth))
            body = encrypted(message.content, keys, new_message_key(), secrets.token_bytes(SALT_BYTES))
        except ValueError as error:
            return PushAnswer(f"it cannot be encrypted: {error}", is_gone=True)
        parts = urlsplit(subscription.endpoint)
        headers = {
            "authorization": self._identity.authorization(
                f"{parts.scheme}://{parts.netloc}", self._contact, at
            ),
            "content-type": "application/octet-stream",
            "content-encoding": "aes128gcm",
            "ttl": str(message.ttl_s),
            "urgency": "high",
            "topic": message.topic,
        }
        answer = await self._http.send(subscription.endpoint, headers, body)
        return PushAnswer(answer.failure, answer.status in GONE)
