"""The vehicle's own key: made once, kept to itself, and never replaced silently."""

import base64
import stat
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

from vehicle_agent.link.keys import VehicleKeyError, load_or_create_key, public_key_text, signature_text


def test_the_first_boot_makes_a_key_that_its_owner_alone_can_read_and_later_boots_keep_it(
    tmp_path: Path,
) -> None:
    path = tmp_path / "new folder" / "key.pem"
    made = load_or_create_key(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert public_key_text(load_or_create_key(path)) == public_key_text(made)


def test_the_enrolled_half_verifies_what_the_vehicle_signs(tmp_path: Path) -> None:
    key = load_or_create_key(tmp_path / "key.pem")
    public = base64.b64decode(public_key_text(key))
    assert len(public) == 32
    Ed25519PublicKey.from_public_bytes(public).verify(
        base64.b64decode(signature_text(key, b"hello")), b"hello"
    )


def test_a_file_that_is_no_key_is_named_and_left_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "key.pem"
    path.write_text("not a key")
    with pytest.raises(VehicleKeyError, match=r"key\.pem.*enrol the vehicle again"):
        load_or_create_key(path)
    assert path.read_text() == "not a key"


def test_a_key_of_another_kind_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "key.pem"
    other = X25519PrivateKey.generate()
    path.write_bytes(other.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
    with pytest.raises(VehicleKeyError, match="no Ed25519 key"):
        load_or_create_key(path)
