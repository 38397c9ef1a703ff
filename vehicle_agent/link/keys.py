"""The vehicle's private key: created on the vehicle, never leaves it; its public half is enrolled once."""

import base64
import hmac
import os
from contextlib import suppress
from pathlib import Path

from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    PublicFormat,
    load_pem_private_key,
)


class VehicleKeyError(Exception):
    """The key file cannot be used; the message says what to do."""


def load_or_create_key(path: Path) -> Ed25519PrivateKey:
    """The key at `path`, created there on the first boot (readable by its owner only)."""
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        key = Ed25519PrivateKey.generate()
        pem = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        draft = path.with_name(f".{path.name}.{os.getpid()}")
        file = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        with os.fdopen(file, "wb") as file_object:
            file_object.write(pem)
        # Another process of the vehicle may have been first: then its key is the one.
        with suppress(FileExistsError):
            os.link(draft, path)
        draft.unlink()
    try:
        loaded = load_pem_private_key(path.read_bytes(), password=None)
    except (ValueError, TypeError, UnsupportedAlgorithm) as error:
        raise VehicleKeyError(
            f"{path} is no private key ({error}); remove it and enrol the vehicle again"
        ) from error
    if not isinstance(loaded, Ed25519PrivateKey):
        raise VehicleKeyError(f"{path} is no Ed25519 key; remove it and enrol the vehicle again")
    return loaded


def public_key_text(key: Ed25519PrivateKey) -> str:
    """Base64 of the 32 raw bytes, for enrolment."""
    return base64.b64encode(key.public_key().public_bytes(Encoding.Raw, PublicFormat.Raw)).decode()


def code_key(key: Ed25519PrivateKey) -> bytes:
    """The secret with which boarding codes are masked on the vehicle; it tells nothing of the key."""
    return hmac.digest(key.private_bytes_raw(), b"campusloop boarding codes", "sha256")


def signature_text(key: Ed25519PrivateKey, text: bytes) -> str:
    """Base64 of the Ed25519 signature (RFC 8032)."""
    return base64.b64encode(key.sign(text)).decode()
