"""Messages to browsers are encrypted as RFC 8291 says, and signed as RFC 8292 says."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.asymmetric import ec

from server.push_encryption import (
    BrowserKeys,
    PushIdentity,
    encrypted,
    from_base64url,
    new_message_key,
    point_of,
)
from server.push_key_file import push_identity_of
from tests.server.push_service import PushBrowser, claims_of

NOW = datetime(2026, 11, 23, 8, 0, tzinfo=UTC)
SALT = bytes(16)


def private(text: str) -> ec.EllipticCurvePrivateKey:
    return ec.derive_private_key(int.from_bytes(from_base64url(text)), ec.SECP256R1())


def test_the_example_of_the_rfc_is_encrypted_to_the_same_bytes() -> None:
    """RFC 8291, 5 and appendix A."""
    browser = PushBrowser(
        private("q1dXpw3UpT5VOmu_cf_v6ih07Aems3njxI-JWgLcM94"), from_base64url("BTBZMqHH6r4Tts7J_aSIgg")
    )
    own = private("yfWPiYE-n46HLnH0KqZOF1fJJU3MYrct3AELtAQ-oRw")
    body = encrypted(
        b"When I grow up, I want to be a watermelon",
        browser.keys,
        own,
        from_base64url("DGv6ra1nlYgDCS1FRnbzlw"),
    )
    assert body == from_base64url(
        "DGv6ra1nlYgDCS1FRnbzlwAAEABBBP4z9KsN6nGRTbVYI_c7VJSPQTBtkgcy27ml"
        "mlMoZIIgDll6e3vCYLocInmYWAmS6TlzAC8wEqKK6PBru3jl7A_yl95bQpu6cVPT"
        "pK4Mqgkf1CXztLVBSt2Ks3oZwbuwXPXLWyouBWLVWGNWQexSgSxsj_Qulcy4a-fN"
    )


def test_the_browser_reads_what_was_sent_and_another_one_does_not() -> None:
    browser = PushBrowser()
    body = encrypted("车辆已到站".encode(), browser.keys, new_message_key(), SALT)
    assert browser.decrypted(body).decode() == "车辆已到站"
    with pytest.raises(InvalidTag):
        PushBrowser().decrypted(body)


def test_a_message_that_no_push_service_takes_is_refused() -> None:
    with pytest.raises(ValueError, match="4000 bytes"):
        encrypted(bytes(4_000), PushBrowser().keys, new_message_key(), SALT)


@pytest.mark.parametrize("point", [bytes(1), bytes(65), b"\x04" + bytes(64)])
def test_a_key_that_is_no_point_of_the_curve_is_refused(point: bytes) -> None:
    with pytest.raises(ValueError, match=r"[Pp]oint|[Kk]ey|encod"):
        encrypted(b"here", BrowserKeys(point, bytes(16)), new_message_key(), SALT)


def test_the_signature_names_push_service_and_contact_for_half_a_day() -> None:
    identity = PushIdentity(b"a secret of thirty-two bytes, all")
    claims = claims_of(identity.authorization("https://push.example", "mailto:ops@example.org", NOW))
    assert claims == {
        "aud": "https://push.example",
        "exp": int((NOW + timedelta(hours=12)).timestamp()),
        "sub": "mailto:ops@example.org",
        "key": identity.public_key,
    }
    assert "sub" not in claims_of(identity.authorization("https://push.example", "", NOW))


def test_the_key_is_made_once_and_found_again_by_the_next_start(tmp_path: Path) -> None:
    path = tmp_path / "var" / "push.key"
    made = push_identity_of(path)
    assert path.stat().st_mode & 0o777 == 0o600
    assert push_identity_of(path).public_key == made.public_key
    assert push_identity_of(tmp_path / "other.key").public_key != made.public_key
    point = from_base64url(made.public_key)
    assert point_of(ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), point)) == point
