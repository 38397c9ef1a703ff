"""A script registers a webhook with the real server, and its receiver checks what arrives."""

import asyncio
import base64
import hmac
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from campusloop_sdk import WebhookMessage, WebhookNotVerified, connect, verify_webhook
from tests.campusloop.live.live_server import live_server, obedient_vehicle

SECRET = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw"
BODY = (
    b'{"type":"ride.assigned","timestamp":"2026-09-01T08:00:00Z",'
    b'"data":{"campus_id":"c","number":7,"subject":"r"}}'
)
SENT_S = 1_788_249_600.0
HEADERS = {
    "Webhook-Id": "webhook-1-7",
    "Webhook-Timestamp": "1788249600",
    "Webhook-Signature": "v1,AAAA v1,SIGNATURE",
}


@asynccontextmanager
async def receiving(arrived: "asyncio.Queue[tuple[dict[str, str], bytes]]") -> AsyncIterator[str]:
    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = (await reader.readuntil(b"\r\n\r\n")).decode()
        headers = dict(line.split(": ", 1) for line in head.split("\r\n")[1:] if line)
        length = int(next(value for name, value in headers.items() if name.lower() == "content-length"))
        arrived.put_nowait((headers, await reader.readexactly(length)))
        writer.write(b"HTTP/1.1 204 No Content\r\n\r\n")
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    async with server:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/"


def test_a_script_gets_the_events_of_its_rides(tmp_path: Path) -> None:
    async def run() -> None:
        arrived: asyncio.Queue[tuple[dict[str, str], bytes]] = asyncio.Queue()
        async with (
            asyncio.timeout(40),
            receiving(arrived) as url,
            live_server(tmp_path, webhook_allowed_networks="127.0.0.0/8") as server,
            obedient_vehicle(server),
        ):
            token, _ = await server.developer_token("read", "drive")
            async with connect(server.origin, token) as campus:
                webhook = await campus.webhooks.make(url, ["ride.*"])
                tried = await campus.webhooks.test(webhook.webhook_id)
                assert (tried.delivered, tried.status) == (True, 204)
                assert verified(webhook.secret, await arrived.get()).type == "webhook.test"
                ride = await campus.rides.book("NN20", "C6")
                message = verified(webhook.secret, await arrived.get())
                assert (message.type, message.data.subject) == ("ride.booked", ride.ride_id)
                newer = await campus.webhooks.rotate(webhook.webhook_id)
                await campus.rides.cancel(ride.ride_id)
                last = await arrived.get()
                while verified(newer.secret, last).type != "ride.cancelled":
                    last = await arrived.get()
                assert [one.failures async for one in campus.webhooks.list()] == [0]
                await campus.webhooks.delete(webhook.webhook_id)
                assert [one async for one in campus.webhooks.list()] == []

    asyncio.run(run())


def verified(secret: str, request: tuple[dict[str, str], bytes]) -> WebhookMessage:
    headers, body = request
    return verify_webhook(secret, headers, body)


def signed(body: bytes = BODY, **changed: str) -> tuple[dict[str, str], bytes]:
    """A message as `SECRET` signs it, then changed."""
    key = base64.b64decode(SECRET.removeprefix("whsec_"))
    text = b"webhook-1-7.1788249600." + BODY
    signature = base64.b64encode(hmac.digest(key, text, "sha256")).decode()
    headers = {name: value.replace("SIGNATURE", signature) for name, value in HEADERS.items()}
    return headers | changed, body


def test_a_signed_message_is_verified_whatever_other_signatures_it_has() -> None:
    message = verify_webhook(SECRET, *signed(), now_s=SENT_S)
    assert (message.message_id, message.data.number) == ("webhook-1-7", 7)


@pytest.mark.parametrize(
    ("message", "now_s"),
    [
        (signed(BODY + b" "), SENT_S),
        (signed(**{"Webhook-Id": "webhook-1-8"}), SENT_S),
        (signed(**{"Webhook-Timestamp": "1788249601"}), SENT_S),
        (signed(**{"Webhook-Timestamp": "soon"}), SENT_S),
        (signed(**{"Webhook-Signature": "v1,"}), SENT_S),
        (signed(**{"Webhook-Signature": ""}), SENT_S),
        (signed(), SENT_S + 301.0),
        (signed(), SENT_S - 301.0),
        (({}, BODY), SENT_S),
    ],
)
def test_a_message_that_was_changed_or_is_old_is_not_verified(
    message: tuple[dict[str, str], bytes], now_s: float
) -> None:
    with pytest.raises(WebhookNotVerified):
        verify_webhook(SECRET, *message, now_s=now_s)


@pytest.mark.parametrize("secret", ["whsec_AAAA", "", "whsec_", "not base64!"])
def test_another_secret_verifies_nothing(secret: str) -> None:
    with pytest.raises(WebhookNotVerified):
        verify_webhook(secret, *signed(), now_s=SENT_S)
