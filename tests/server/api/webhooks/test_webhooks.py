"""Webhooks over REST: who may make, see and change them, and what is refused."""

from pathlib import Path

import pytest

from tests.server.api.server_under_test import ServerUnderTest

BODY = {"url": "https://hooks.example.org/campus", "event_types": ["ride.*"]}


def bearer(server: ServerUnderTest, *scopes: str) -> dict[str, str]:
    made = server.post(
        "/developer-tokens", {"name": "script", "scopes": list(scopes)}, headers=server.sign_in()
    )
    server.client.cookies.clear()
    return {"Authorization": f"Bearer {made.json()['secret']}"}


def test_a_developer_makes_lists_rotates_and_deletes_a_webhook(server: ServerUnderTest) -> None:
    script = bearer(server, "drive", "read")
    made = server.post("/webhooks", BODY, headers=script)
    assert made.status_code == 201
    path = f"/webhooks/{made.json()['webhook_id']}"
    (listed,) = server.get("/webhooks", headers=script).json()
    assert listed | {"secret": made.json()["secret"]} == made.json()
    rotated = server.post(f"{path}/rotate", headers=script).json()
    assert rotated["secret_version"] == 2
    assert rotated["secret"] != made.json()["secret"]
    assert server.post(f"{path}/enable", headers=script).status_code == 200
    assert server.request("DELETE", path, headers=script).status_code == 204
    assert server.get("/webhooks", headers=script).json() == []


def test_a_developer_does_not_see_what_another_token_has_made_and_an_operator_does(
    server: ServerUnderTest,
) -> None:
    one, other = bearer(server, "drive", "read"), bearer(server, "drive", "read")
    webhook_id = server.post("/webhooks", BODY, headers=one).json()["webhook_id"]
    assert server.get("/webhooks", headers=other).json() == []
    for change in ("rotate", "enable", "test"):
        refused = server.post(f"/webhooks/{webhook_id}/{change}", headers=other)
        assert (refused.status_code, refused.json()["code"]) == (404, "webhook_unknown")
    server.sign_in()
    assert [one["webhook_id"] for one in server.get("/webhooks").json()] == [webhook_id]


def test_making_one_needs_the_scope_drive(server: ServerUnderTest) -> None:
    assert server.post("/webhooks", BODY, headers=bearer(server, "read")).status_code == 403
    assert server.post("/webhooks", BODY).status_code == 401


def test_a_repeat_with_the_key_gets_the_same_secret(server: ServerUnderTest) -> None:
    script = bearer(server, "drive", "read") | {"Idempotency-Key": "make-the-webhook"}
    first, again = (server.post("/webhooks", BODY, headers=script).json() for _ in range(2))
    assert first == again
    assert len(server.get("/webhooks", headers=script).json()) == 1


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({"url": "http://hooks.example.org/"}, 400),
        ({"url": "https://user@hooks.example.org/"}, 400),
        ({"event_types": ["operator.password_set"]}, 400),
        ({"event_types": ["*"]}, 422),
        ({"event_types": []}, 422),
        ({"other": 1}, 422),
    ],
)
def test_what_cannot_be_a_webhook_is_refused(
    server: ServerUnderTest, change: dict[str, object], status: int
) -> None:
    assert server.post("/webhooks", BODY | change, headers=bearer(server, "drive")).status_code == status


def test_a_plain_address_is_taken_where_a_setting_allows_its_network(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, webhook_allowed_networks="10.0.0.0/8")
    plain = BODY | {"url": "http://10.1.2.3/"}
    assert server.post("/webhooks", plain, headers=bearer(server, "drive")).status_code == 201
    server.close()


def test_a_server_without_networks_refuses_to_test_one(server: ServerUnderTest) -> None:
    script = bearer(server, "drive")
    path = f"/webhooks/{server.post('/webhooks', BODY, headers=script).json()['webhook_id']}/test"
    refused = server.post(path, headers=script)
    assert (refused.status_code, refused.json()["code"]) == (409, "webhook_disabled")
