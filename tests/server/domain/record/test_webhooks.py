"""The rules of webhooks: what may be registered, when attempts are made, and how messages are signed."""

import base64
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.domain.errors import WebhookInvalid
from server.domain.record.webhooks import (
    JITTER_RATIO,
    PAUSES_S,
    ROTATION_S,
    SigningKey,
    Webhook,
    after_delivery,
    after_failure,
    checked_types,
    checked_url,
    pause_s,
    rotated,
    signed_headers,
)

NOW = datetime(2026, 9, 1, 8, 0, tzinfo=UTC)
CHANCE = st.floats(0.0, 1.0, exclude_max=True)


def a_webhook(**more: object) -> Webhook:
    made = Webhook("c", "w", "https://a.example", ("ride.*",), "developer:t", "t", NOW, SigningKey("k", 1), 5)
    return replace(made, **more)  # type: ignore[arg-type]


@given(st.integers(1, 10_000), CHANCE, CHANCE)
def test_pauses_grow_with_the_failures_up_to_a_day(failures: int, one: float, other: float) -> None:
    pause, later = pause_s(failures, one), pause_s(failures + 1, other)
    assert PAUSES_S[0] <= pause <= PAUSES_S[-1] * (1.0 + JITTER_RATIO)
    assert later > pause or failures + 1 > len(PAUSES_S)


@given(st.lists(CHANCE, min_size=1, max_size=40))
def test_attempts_that_fail_are_due_later_and_later_and_never_before_their_time(chances: list[float]) -> None:
    webhook, at = a_webhook(), NOW
    for chance in chances:
        webhook = after_failure(webhook, "refused", at, chance)
        assert webhook.next_attempt_at is not None
        assert webhook.next_attempt_at - at >= timedelta(seconds=PAUSES_S[0])
        assert not webhook.is_due(webhook.next_attempt_at - timedelta(microseconds=1))
        assert webhook.is_due(webhook.next_attempt_at)
        at = webhook.next_attempt_at
    assert (webhook.failures, webhook.failing_since, webhook.cursor) == (len(chances), NOW, 5)


@given(CHANCE)
def test_eight_attempts_lie_in_the_first_three_days(chance: float) -> None:
    assert sum(pause_s(number, chance) for number in range(1, 8)) < 3 * 86_400.0


@given(st.integers(0, 100), st.integers(0, 100))
def test_the_cursor_never_goes_back(before: int, number: int) -> None:
    assert after_delivery(a_webhook(cursor=before), number, NOW).cursor == max(before, number)


def test_a_delivery_ends_the_failures() -> None:
    webhook = after_delivery(after_failure(a_webhook(), "refused", NOW, 0.0), 6, NOW)
    assert (webhook.failures, webhook.failing_since, webhook.next_attempt_at) == (0, None, None)
    assert webhook.last_failure == "refused"


def test_a_new_secret_signs_together_with_the_old_one_for_a_day() -> None:
    webhook = rotated(a_webhook(), "newer", NOW)
    later = NOW + timedelta(seconds=ROTATION_S)
    assert webhook.keys_at(later - timedelta(seconds=1)) == (SigningKey("newer", 2), SigningKey("k", 1))
    assert webhook.keys_at(later) == (SigningKey("newer", 2),)


def test_signatures_are_those_of_the_specification() -> None:
    """The example of the Standard Webhooks libraries."""
    key = base64.b64decode("MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw")
    sent = datetime.fromtimestamp(1_614_265_330, UTC)
    headers = signed_headers([key], "msg_p5jXN8AQM9LWM0D4loKWxJek", sent, b'{"test": 2432232314}')
    assert headers == {
        "webhook-id": "msg_p5jXN8AQM9LWM0D4loKWxJek",
        "webhook-timestamp": "1614265330",
        "webhook-signature": "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=",
    }


@pytest.mark.parametrize(
    "url",
    [
        "http://hooks.example.org/",
        "ftp://hooks.example.org/",
        "https:///path",
        "https://user:word@hooks.example.org/",
        "https://hooks.example.org/#part",
        "https://hooks.example.org:99999/",
        "https://hooks.example.org:0/",
        "https://hooks.example.org/a b",
        "https://hooks.example.org/\r\nHost: other",
        "https://hooks.exämple.org/",
        "https://[::1",
        "https://hooks.example.org/" + "a" * 1_000,
    ],
)
def test_an_address_that_cannot_be_used_is_refused(url: str) -> None:
    with pytest.raises(WebhookInvalid):
        checked_url(url, may_be_plain=False)


def test_a_plain_address_is_allowed_where_private_networks_are() -> None:
    assert checked_url("http://10.0.0.7/", may_be_plain=True) == "http://10.0.0.7/"


@pytest.mark.parametrize(
    "name", ["*", "ride", "ride.", "operator.*", "token.made", "webhook.test", "ride.*x", "%.*"]
)
def test_a_type_that_is_not_for_developers_is_refused(name: str) -> None:
    with pytest.raises(WebhookInvalid):
        checked_types([name])


def test_types_are_kept_once_and_sorted() -> None:
    assert checked_types(["ride.*", "incident.opened", "ride.*"]) == ("incident.opened", "ride.*")
