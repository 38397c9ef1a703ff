"""Messages to browsers, encrypted so that the push service between cannot read them.

RFC 8291 (keys), RFC 8188 (content coding aes128gcm) and RFC 8292 (the server's signature, VAPID). No I/O.
"""

import base64
import hashlib
import json
from dataclasses import dataclass, field
from datetime import datetime

from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.asymmetric.utils import decode_dss_signature
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDF
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

SALT_BYTES = 16
# One record holds the whole message; push services take bodies of 4096 bytes (RFC 8030, 7.2).
RECORD_BYTES = 4_096
# A push service refuses a signature that is good for more than a day (RFC 8292, 2).
SIGNATURE_S = 12 * 3600
_CURVE = ec.SECP256R1()
# n of P-256 (SEC 2, 2.4.2): private keys are 1 to n - 1.
_ORDER = 0xFFFFFFFF00000000FFFFFFFFFFFFFFFFBCE6FAADA7179E84F3B9CAC2FC632551
_LAST_RECORD = b"\x02"


@dataclass(frozen=True, slots=True)
class BrowserKeys:
    """What a browser gives with its subscription: a point of P-256 (65 bytes) and a secret (16 bytes)."""

    p256dh: bytes = field(repr=False)
    auth: bytes = field(repr=False)


class PushIdentity:
    """The server as push services know it: the key whose public half browsers subscribe with.

    secret  32 bytes or more, of which the private key is made
    """

    def __init__(self, secret: bytes) -> None:
        digest = hashlib.sha512(b"campusloop push key\n" + secret).digest()
        self._key = ec.derive_private_key(1 + int.from_bytes(digest) % (_ORDER - 1), _CURVE)

    @property
    def public_key(self) -> str:
        """The uncompressed point in base64url, as `applicationServerKey` of a page."""
        return base64url(point_of(self._key.public_key()))

    def authorization(self, origin: str, contact: str, at: datetime) -> str:
        """The header of a request to this push service.

        origin   of the push service, `https://push.example`
        contact  `mailto:` or `https:` of those who run the server; "" for none
        """
        claims: dict[str, object] = {"aud": origin, "exp": int(at.timestamp()) + SIGNATURE_S}
        if contact:
            claims["sub"] = contact
        signed = ".".join(
            base64url(json.dumps(part).encode()) for part in ({"typ": "JWT", "alg": "ES256"}, claims)
        )
        r, s = decode_dss_signature(self._key.sign(signed.encode(), ec.ECDSA(SHA256())))
        signature = r.to_bytes(32) + s.to_bytes(32)
        return f"vapid t={signed}.{base64url(signature)}, k={self.public_key}"


def encrypted(message: bytes, browser: BrowserKeys, own: ec.EllipticCurvePrivateKey, salt: bytes) -> bytes:
    """The body for a push service, in one record.

    own   a key of this message alone
    salt  SALT_BYTES, of this message alone

    Raises ValueError for a browser key that is no point of P-256, and a message that is too long.
    """
    assert len(salt) == SALT_BYTES
    own_point = point_of(own.public_key())
    shared = own.exchange(ec.ECDH(), ec.EllipticCurvePublicKey.from_encoded_point(_CURVE, browser.p256dh))
    key, nonce = content_keys(shared, browser, own_point, salt)
    sealed = AESGCM(key).encrypt(nonce, message + _LAST_RECORD, None)
    header = salt + RECORD_BYTES.to_bytes(4) + bytes([len(own_point)]) + own_point
    if len(header) + len(sealed) > RECORD_BYTES:
        raise ValueError(f"the message has {len(message)} bytes, more than a push service takes")
    return header + sealed


def content_keys(shared: bytes, browser: BrowserKeys, own_point: bytes, salt: bytes) -> tuple[bytes, bytes]:
    """Key and nonce of the message (RFC 8291, 3.4): 16 and 12 bytes."""
    info = b"WebPush: info\x00" + browser.p256dh + own_point
    secret = _derived(shared, browser.auth, info, 32)
    key = _derived(secret, salt, b"Content-Encoding: aes128gcm\x00", 16)
    return key, _derived(secret, salt, b"Content-Encoding: nonce\x00", 12)


def new_message_key() -> ec.EllipticCurvePrivateKey:
    return ec.generate_private_key(_CURVE)


def point_of(key: ec.EllipticCurvePublicKey) -> bytes:
    return key.public_bytes(Encoding.X962, PublicFormat.UncompressedPoint)


def base64url(content: bytes) -> str:
    return base64.urlsafe_b64encode(content).rstrip(b"=").decode()


def from_base64url(text: str) -> bytes:
    """Raises ValueError."""
    return base64.urlsafe_b64decode(text.rstrip("=") + "=" * (-len(text.rstrip("=")) % 4))


def _derived(secret: bytes, salt: bytes, info: bytes, length: int) -> bytes:
    return HKDF(SHA256(), length, salt, info).derive(secret)
