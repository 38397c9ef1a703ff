"""A browser's push service of our own, with the browsers behind it: it checks and decrypts every message."""

import asyncio
import base64
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.asymmetric.utils import encode_dss_signature
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.hashes import SHA256

from server.push_encryption import BrowserKeys, content_keys, from_base64url, point_of

SALT_BYTES, POINT_BYTES = 16, 65


@dataclass
class PushBrowser:
    """A browser with a subscription. Its key may be given, as in the example of RFC 8291."""

    key: ec.EllipticCurvePrivateKey = field(default_factory=lambda: ec.generate_private_key(ec.SECP256R1()))
    auth: bytes = b"sixteen secrets!"

    @property
    def keys(self) -> BrowserKeys:
        return BrowserKeys(point_of(self.key.public_key()), self.auth)

    def subscription(self, endpoint: str, language: str = "en") -> dict[str, str]:
        """The body of a request for notices."""
        return {
            "endpoint": endpoint,
            "p256dh": base64.urlsafe_b64encode(self.keys.p256dh).rstrip(b"=").decode(),
            "auth": base64.urlsafe_b64encode(self.auth).rstrip(b"=").decode(),
            "language": language,
        }

    def decrypted(self, body: bytes) -> bytes:
        """As RFC 8291, 3.4 says it to the browser. InvalidTag for what is not encrypted for it."""
        salt, point = body[:SALT_BYTES], body[21 : 21 + POINT_BYTES]
        assert (int.from_bytes(body[16:20]), body[20]) == (4_096, POINT_BYTES)
        sender = ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), point)
        key, nonce = content_keys(self.key.exchange(ec.ECDH(), sender), self.keys, point, salt)
        padded = AESGCM(key).decrypt(nonce, body[21 + POINT_BYTES :], None)
        assert padded.endswith(b"\x02")
        return padded[:-1]


@dataclass
class PushService:
    """It answers with `statuses`, then with 201; a status of 0 is no answer at all."""

    browser: PushBrowser = field(default_factory=PushBrowser)
    statuses: list[int] = field(default_factory=list)
    attempts: int = 0
    notices: list[dict[str, Any]] = field(default_factory=list)
    headers: list[dict[str, str]] = field(default_factory=list)
    origin: str = ""

    @property
    def endpoint(self) -> str:
        return f"{self.origin}/send/one"

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = (await reader.readuntil(b"\r\n\r\n")).decode()
        lines = [line.split(": ", 1) for line in head.split("\r\n")[1:] if line]
        headers = {name.lower(): value for name, value in lines}
        body = await reader.readexactly(int(headers["content-length"]))
        self.attempts += 1
        status = self.statuses.pop(0) if self.statuses else 201
        if status == 201:
            self.headers.append(headers)
            self.notices.append(json.loads(self.browser.decrypted(body)))
        if status:
            writer.write(f"HTTP/1.1 {status} Said\r\ncontent-length: 0\r\n\r\n".encode())
            await writer.drain()
        else:
            await reader.read()
        writer.close()


@asynccontextmanager
async def serving(service: PushService) -> AsyncIterator[PushService]:
    server = await asyncio.start_server(service.serve, "127.0.0.1", 0)
    service.origin = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
    async with server:
        yield service


def claims_of(authorization: str) -> dict[str, Any]:
    """What the server says of itself. InvalidSignature unless it was signed with the key that it names."""
    parts = dict(part.strip().split("=", 1) for part in authorization.removeprefix("vapid ").split(","))
    signed, _, signature = parts["t"].rpartition(".")
    raw = from_base64url(signature)
    named = ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), from_base64url(parts["k"]))
    pair = encode_dss_signature(int.from_bytes(raw[:32]), int.from_bytes(raw[32:]))
    named.verify(pair, signed.encode(), ec.ECDSA(SHA256()))
    claims: dict[str, Any] = json.loads(from_base64url(signed.split(".")[1]))
    return claims | {"key": parts["k"]}
