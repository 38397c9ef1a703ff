"""Webhooks: addresses of developers that get recorded events, in order and signed.

Signatures and the pauses between attempts are those of the Standard Webhooks specification,
https://github.com/standard-webhooks/standard-webhooks/blob/main/spec/standard-webhooks.md.
"""

import base64
import hmac
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from urllib.parse import urlsplit

from server.domain.errors import WebhookDisabled, WebhookInvalid

# After the first failure, the second one, and so on; the last one repeats.
PAUSES_S = (5.0, 300.0, 1_800.0, 7_200.0, 18_000.0, 36_000.0, 50_400.0, 72_000.0, 86_400.0)
# A pause is up to so much longer, so that webhooks that failed together are not tried together.
JITTER_RATIO = 0.1
# So long after a rotation, messages are signed with the old secret as well.
ROTATION_S = 86_400.0
URL_CHARACTERS_MAX = 1_000
CAUSE_CHARACTERS_MAX = 200
SECRET_PREFIX = "whsec_"

# Events of operators, tokens and keys are not sent.
SUBJECTS = (
    "announcement",
    "closure",
    "incident",
    "map",
    "order",
    "plan",
    "ride",
    "series",
    "vehicle",
    "visit",
)
TEST_EVENT = "webhook.test"
_TYPE = re.compile(rf"({'|'.join(SUBJECTS)})\.(\*|[a-z][a-z_]{{0,50}})")


@dataclass(frozen=True, slots=True)
class SigningKey:
    """Names a secret, which is derived and stored nowhere: the server's ticket key and a version."""

    ticket_key_id: str
    version: int


@dataclass(frozen=True, slots=True)
class Webhook:
    """account, made_by: the operator or developer token that made it.

    event_types      `noun.verb`, or `noun.*` for all of one noun
    cursor           number of the last recorded event that was delivered or passed over
    failures         attempts in a row that failed, the first of them at failing_since
    disabled_at      nothing is sent since then; disabled_reason says why
    """

    campus_id: str
    webhook_id: str
    url: str
    event_types: tuple[str, ...]
    account: str
    made_by: str
    created_at: datetime
    key: SigningKey
    cursor: int
    old_key: SigningKey | None = None
    old_key_until: datetime | None = None
    last_success_at: datetime | None = None
    last_failure_at: datetime | None = None
    last_failure: str = ""
    failures: int = 0
    failing_since: datetime | None = None
    next_attempt_at: datetime | None = None
    disabled_at: datetime | None = None
    disabled_reason: str = ""

    def keys_at(self, now: datetime) -> tuple[SigningKey, ...]:
        """What messages are signed with, newest first."""
        if self.old_key is None or self.old_key_until is None or self.old_key_until <= now:
            return (self.key,)
        return (self.key, self.old_key)

    def is_due(self, now: datetime) -> bool:
        return self.disabled_at is None and (self.next_attempt_at is None or self.next_attempt_at <= now)


def checked_url(url: str, may_be_plain: bool) -> str:
    """The address, if messages can be sent to it. Raises WebhookInvalid.

    may_be_plain  http is allowed as well as https
    """
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise WebhookInvalid(f"the address cannot be read: {error}") from error
    if parts.scheme != "https" and not (may_be_plain and parts.scheme == "http"):
        raise WebhookInvalid("the address must begin with https://")
    is_printable = url.isascii() and url.isprintable() and " " not in url
    if not host or not is_printable or len(url) > URL_CHARACTERS_MAX or port == 0:
        raise WebhookInvalid(
            f"give a host, in at most {URL_CHARACTERS_MAX} printable ASCII characters without spaces"
        )
    if "@" in parts.netloc or parts.fragment:
        raise WebhookInvalid("the address must have no user, password or fragment")
    return url


def checked_types(event_types: Sequence[str]) -> tuple[str, ...]:
    """Sorted, each once. Raises WebhookInvalid."""
    for name in event_types:
        if _TYPE.fullmatch(name) is None:
            raise WebhookInvalid(
                f"{name!r} is no type of event: give noun.verb or noun.*, of {', '.join(SUBJECTS)}"
            )
    if not event_types:
        raise WebhookInvalid("give at least one type of event")
    return tuple(sorted(set(event_types)))


def pause_s(failures: int, chance: float) -> float:
    """The time until the next attempt after so many failures in a row, at least one.

    chance  in [0, 1)
    """
    return PAUSES_S[min(failures, len(PAUSES_S)) - 1] * (1.0 + JITTER_RATIO * chance)


def after_delivery(webhook: Webhook, number: int, at: datetime) -> Webhook:
    """The events up to this number have arrived. The cursor never goes back."""
    return replace(
        webhook,
        cursor=max(webhook.cursor, number),
        last_success_at=at,
        failures=0,
        failing_since=None,
        next_attempt_at=None,
    )


def after_failure(webhook: Webhook, cause: str, at: datetime, chance: float) -> Webhook:
    """An attempt has failed; the next one comes later."""
    failures = webhook.failures + 1
    return replace(
        webhook,
        last_failure_at=at,
        last_failure=cause[:CAUSE_CHARACTERS_MAX],
        failures=failures,
        failing_since=webhook.failing_since or at,
        next_attempt_at=at + timedelta(seconds=pause_s(failures, chance)),
    )


def disabled(webhook: Webhook, reason: str, at: datetime) -> Webhook:
    return replace(webhook, disabled_at=at, disabled_reason=reason, next_attempt_at=None)


def enabled(webhook: Webhook) -> Webhook:
    """Tried again at once, from where it stopped. Enabling an enabled one makes it due."""
    return replace(
        webhook, disabled_at=None, disabled_reason="", failures=0, failing_since=None, next_attempt_at=None
    )


def rotated(webhook: Webhook, ticket_key_id: str, at: datetime) -> Webhook:
    """A new secret; the present one signs for a while longer."""
    return replace(
        webhook,
        key=SigningKey(ticket_key_id, webhook.key.version + 1),
        old_key=webhook.key,
        old_key_until=at + timedelta(seconds=ROTATION_S),
    )


def require_enabled(webhook: Webhook) -> None:
    """Raises WebhookDisabled."""
    if webhook.disabled_at is not None:
        raise WebhookDisabled(f"webhook {webhook.webhook_id} is disabled ({webhook.disabled_reason})")


def secret_text(key: bytes) -> str:
    """A secret as developers get it."""
    return SECRET_PREFIX + base64.b64encode(key).decode()


def signed_headers(keys: Sequence[bytes], message_id: str, at: datetime, body: bytes) -> dict[str, str]:
    """The headers of a message, with one signature for each key."""
    timestamp = str(int(at.timestamp()))
    content = f"{message_id}.{timestamp}.".encode() + body
    signatures = (base64.b64encode(hmac.digest(key, content, "sha256")).decode() for key in keys)
    return {
        "webhook-id": message_id,
        "webhook-timestamp": timestamp,
        "webhook-signature": " ".join(f"v1,{signature}" for signature in signatures),
    }
