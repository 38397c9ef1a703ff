"""The vehicle's private key: created on the vehicle, never leaves it; its public half is enrolled once."""

import base64
import os
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
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(file, "wb") as file_object:
            file_object.write(pem)
        return key
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


def signature_text(key: Ed25519PrivateKey, text: bytes) -> str:
    """Base64 of the Ed25519 signature (RFC 8032)."""
    return base64.b64encode(key.sign(text)).decode()
