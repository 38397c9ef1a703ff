"""Who sees which webhook, and what ends with a token."""

from collections.abc import Iterator

import pytest

from server.domain.errors import TooManyWebhooks, WebhookUnknown
from server.domain.record.webhooks import Webhook
from server.usecases.record import identity
from server.usecases.record.webhooks import registration
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.shipped_maps import shipped_map

URL = "https://hooks.example.org/campus"


@pytest.fixture
def campus() -> Iterator[CampusUnderTest]:
    campus = CampusUnderTest(shipped_map("snow-lion"))
    yield campus
    campus.close()


def a_webhook(campus: CampusUnderTest, account: str) -> Webhook:
    return campus.do(lambda uow: registration.create(uow, URL, ("ride.*",), account, "test")).webhook


def test_a_developer_sees_and_changes_only_its_own(campus: CampusUnderTest) -> None:
    mine, other = a_webhook(campus, "developer:t1"), a_webhook(campus, "developer:t2")
    assert campus.read(lambda uow: registration.listed(uow, "developer:t1")) == (mine,)
    assert campus.read(lambda uow: registration.listed(uow, None)) == (mine, other)
    for change in (registration.rotate, registration.enable, registration.delete):
        with pytest.raises(WebhookUnknown):
            campus.do(lambda uow, change=change: change(uow, other.webhook_id, "developer:t1", "test"))  # type: ignore[misc]


def test_a_revoked_token_ends_its_webhooks_and_no_other(campus: CampusUnderTest) -> None:
    token = campus.do(lambda uow: identity.create_developer_token(uow, "t", ["drive"], 60.0, "ann")).token
    ended, other = a_webhook(campus, f"developer:{token.token_id}"), a_webhook(campus, "operator:1")
    campus.do(lambda uow: identity.revoke_developer_token(uow, token.token_id, "ann"))
    found = {one.webhook_id: one.disabled_reason for one in campus.read(lambda uow: uow.webhooks.all())}
    assert found == {ended.webhook_id: "its developer token was revoked", other.webhook_id: ""}


def test_secrets_differ_by_webhook_and_version(campus: CampusUnderTest) -> None:
    def make() -> list[str]:
        one = campus.do(lambda uow: registration.create(uow, URL, ("ride.*",), "o", "test"))
        new = campus.do(lambda uow: registration.rotate(uow, one.webhook.webhook_id, None, "test"))
        return [one.secret, new.secret]

    secrets = make() + make()
    assert len(set(secrets)) == 4
    assert all(secret.startswith("whsec_") for secret in secrets)


def test_a_campus_has_a_limit_of_webhooks(campus: CampusUnderTest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registration, "WEBHOOKS_MAX", 1)
    a_webhook(campus, "o")
    with pytest.raises(TooManyWebhooks):
        a_webhook(campus, "o")
