"""A browser asks to be told of a ride by the ride's link, where the server sends notices at all."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from server.domain.rides.rides import Ride, RideState
from server.push_encryption import PushIdentity
from server.push_sender import WebPushSender
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides.tickets import secrets_of
from server.webhook_sender import HttpWebhookSender
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.push_service import PushBrowser

ENDPOINT = "https://push.example/send/one"
WISH = PushBrowser().subscription(ENDPOINT)


@pytest.fixture
def campus(tmp_path: Path) -> Iterator[ServerUnderTest]:
    sender = WebPushSender(PushIdentity(bytes(32)), HttpWebhookSender())
    server = ServerUnderTest(tmp_path, push_sender=sender)
    yield server
    server.close()


def path_of_notices(server: ServerUnderTest) -> str:
    """Of a ride that waits for a shuttle."""

    def work(uow: UnitOfWork) -> str:
        ride = Ride(
            uow.campus_id,
            "ride-1",
            "K7MQ2X",
            uow.tickets.newest_id,
            RideState.REQUESTED,
            "NN20",
            "C6",
            1,
            0,
            uow.now,
            uow.now,
            "passenger",
        )
        uow.rides.add(ride)
        return secrets_of(uow, ride).token

    return f"/rides/{server.transact(work)}/notices"


def test_a_page_gets_the_key_that_its_browser_subscribes_with(campus: ServerUnderTest) -> None:
    key = campus.get("/campus/notices").json()["public_key"]
    assert key == PushIdentity(bytes(32)).public_key


def test_a_server_that_sends_nothing_says_so(server: ServerUnderTest) -> None:
    assert server.get("/campus/notices").json() == {"public_key": ""}
    answer = server.request("PUT", path_of_notices(server), json=WISH)
    assert (answer.status_code, answer.json()["code"]) == (409, "notices_unavailable")


@pytest.mark.parametrize(
    ("change", "status", "code"),
    [
        ({"endpoint": "http://push.example/send/one"}, 400, "push_subscription_invalid"),
        ({"endpoint": "https://user:pass@push.example/"}, 400, "push_subscription_invalid"),
        ({"p256dh": "short"}, 422, "payload_invalid"),
        ({"auth": "short"}, 422, "payload_invalid"),
        ({"language": "fr"}, 422, "payload_invalid"),
    ],
)
def test_a_subscription_that_cannot_be_is_refused(
    campus: ServerUnderTest, change: dict[str, str], status: int, code: str
) -> None:
    answer = campus.request("PUT", path_of_notices(campus), json=WISH | change)
    assert (answer.status_code, answer.json()["code"]) == (status, code)


def test_who_asked_can_stop_it_and_nothing_shows_the_address(campus: ServerUnderTest) -> None:
    path = path_of_notices(campus)
    made = campus.request("PUT", path, json=WISH)
    assert made.status_code == 200, made.text
    assert "push.example" not in made.text
    stored = campus.transact(lambda uow: uow.push_subscriptions.all())
    assert [one.endpoint for one in stored] == [ENDPOINT]
    assert "push.example" not in repr(stored)
    for _ in range(2):
        assert campus.request("DELETE", f"{path}/{made.json()['subscription_id']}").status_code == 204
    assert campus.transact(lambda uow: uow.push_subscriptions.all()) == ()


def test_a_link_of_no_ride_gets_nothing(campus: ServerUnderTest) -> None:
    answer = campus.request("PUT", f"/rides/{'x' * 32}/notices", json=WISH)
    assert (answer.status_code, answer.json()["code"]) == (404, "ride_unknown")
