"""Webhooks: register addresses, and check the messages that arrive there.

message = verify_webhook(secret, request.headers, request.body)
"""

import base64
import binascii
import hmac
import time
from collections.abc import AsyncIterator, Iterable, Mapping, Sequence
from datetime import datetime
from urllib.parse import quote

import msgspec

from campusloop_sdk.errors import CampusError
from campusloop_sdk.rest import Params, Rest

SECRET_PREFIX = "whsec_"
TOLERANCE_S = 300.0
PAGE = 200


class WebhookNotVerified(CampusError):
    """The message is not from the campus, was changed on its way, or is too old. Answer it with 400."""


class Webhook(msgspec.Struct, frozen=True):
    """failures: attempts in a row that failed; disabled_at: nothing is sent since then."""

    webhook_id: str
    url: str
    event_types: tuple[str, ...]
    made_by: str
    created_at: datetime
    secret_version: int
    last_success_at: datetime | None
    last_failure_at: datetime | None
    last_failure: str
    failures: int
    next_attempt_at: datetime | None
    disabled_at: datetime | None
    disabled_reason: str


class WebhookWithSecret(Webhook, frozen=True):
    """secret: shown this once; keep it where `verify_webhook` runs."""

    secret: str


class WebhookTest(msgspec.Struct, frozen=True):
    """How the address answered to a test message; status 0: not at all."""

    delivered: bool
    status: int
    failure: str


class WebhookData(msgspec.Struct, frozen=True):
    """number: grows with each event of the campus; subject: id of the ride, vehicle or incident."""

    campus_id: str
    number: int
    subject: str


class WebhookMessage(msgspec.Struct, frozen=True):
    """message_id: the same in every attempt, so that a repeat can be recognised."""

    type: str
    timestamp: datetime
    data: WebhookData
    message_id: str = ""


class Webhooks:
    """key: names a command across repeats; the same key twice gives the first answer."""

    def __init__(self, rest: Rest) -> None:
        self._rest = rest

    def list(self, page: int = PAGE) -> AsyncIterator[Webhook]:
        """Those that this token has made, oldest first. Scope `read`."""
        params: Params = {"limit": page}
        return self._rest.listed("/webhooks", Webhook, params)

    async def make(
        self, url: str, event_types: Sequence[str], *, key: str | None = None
    ) -> WebhookWithSecret:
        """event_types: `noun.verb` or `noun.*`, e.g. `ride.*`. Scope `drive`."""
        body = {"url": url, "event_types": list(event_types)}
        return await self._rest.command("POST", "/webhooks", WebhookWithSecret, body=body, key=key)

    async def rotate(self, webhook_id: str, *, key: str | None = None) -> WebhookWithSecret:
        """A new secret; for a day messages are signed with the old one as well. Scope `drive`."""
        path = f"/webhooks/{_step(webhook_id)}/rotate"
        return await self._rest.command("POST", path, WebhookWithSecret, key=key)

    async def enable(self, webhook_id: str, *, key: str | None = None) -> Webhook:
        """Deliver again, at once and from where it stopped. Scope `drive`."""
        return await self._rest.command("POST", f"/webhooks/{_step(webhook_id)}/enable", Webhook, key=key)

    async def test(self, webhook_id: str) -> WebhookTest:
        """Send a message of the type `webhook.test` now. Scope `drive`."""
        return await self._rest.command("POST", f"/webhooks/{_step(webhook_id)}/test", WebhookTest)

    async def delete(self, webhook_id: str, *, key: str | None = None) -> None:
        """Scope `drive`."""
        await self._rest.command("DELETE", f"/webhooks/{_step(webhook_id)}", type(None), key=key)


def verify_webhook(
    secret: str,
    headers: Mapping[str, str],
    body: bytes,
    *,
    now_s: float | None = None,
    tolerance_s: float = TOLERANCE_S,
) -> WebhookMessage:
    """The message, if it is signed with this secret and recent.

    headers  of the request, in any case of letters
    body     its bytes as they came
    now_s    Unix time; None: the computer's

    Raises WebhookNotVerified.
    """
    lower = {name.lower(): value for name, value in headers.items()}
    try:
        message_id, timestamp = lower["webhook-id"], lower["webhook-timestamp"]
        signatures, sent_s = lower["webhook-signature"].split(), int(timestamp)
        key = base64.b64decode(secret.removeprefix(SECRET_PREFIX), validate=True)
    except KeyError as error:
        raise WebhookNotVerified(f"the header {error} is missing") from error
    except (ValueError, binascii.Error) as error:
        raise WebhookNotVerified(f"the secret or the timestamp cannot be read: {error}") from error
    if not key:
        raise WebhookNotVerified("the secret is empty")
    if abs((time.time() if now_s is None else now_s) - sent_s) > tolerance_s:
        raise WebhookNotVerified("the message is too old, or a clock is wrong")
    content = f"{message_id}.{timestamp}.".encode() + body
    expected = "v1," + base64.b64encode(hmac.digest(key, content, "sha256")).decode()
    if not _is_among(expected, signatures):
        raise WebhookNotVerified("no signature is made with this secret")
    try:
        message = msgspec.json.decode(body, type=WebhookMessage)
    except msgspec.DecodeError as error:
        raise WebhookNotVerified(f"the message cannot be read: {error}") from error
    return msgspec.structs.replace(message, message_id=message_id)


def _is_among(expected: str, signatures: Iterable[str]) -> bool:
    found = False
    for signature in signatures:
        found |= hmac.compare_digest(signature.encode(), expected.encode())
    return found


def _step(value: str) -> str:
    """An id as one step of a path."""
    return quote(value, safe="")
