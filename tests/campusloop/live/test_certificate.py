import ipaddress
import ssl
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509

from campusloop.live.certificate import (
    RENEW_DAYS,
    VALID_DAYS,
    local_addresses,
    self_signed,
)

NOW = datetime(2026, 9, 1, tzinfo=UTC)
NAMES = ("127.0.0.1", "campus.local")


def test_the_certificate_names_every_address_and_can_be_loaded_with_its_key(tmp_path: Path) -> None:
    certificate, key = self_signed(tmp_path / "tls", NAMES, NOW)
    ssl.create_default_context(ssl.Purpose.CLIENT_AUTH).load_cert_chain(certificate, key)
    parsed = x509.load_pem_x509_certificate(certificate.read_bytes())
    held = parsed.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert held.get_values_for_type(x509.IPAddress) == [ipaddress.ip_address("127.0.0.1")]
    assert held.get_values_for_type(x509.DNSName) == ["campus.local"]
    assert key.stat().st_mode & 0o077 == 0


def test_a_usable_certificate_is_kept_so_that_browsers_ask_once(tmp_path: Path) -> None:
    first = self_signed(tmp_path, NAMES, NOW)[0].read_bytes()
    assert self_signed(tmp_path, NAMES[:1], NOW + timedelta(days=100))[0].read_bytes() == first


def test_it_is_made_anew_for_another_address_or_near_its_end(tmp_path: Path) -> None:
    first = self_signed(tmp_path, NAMES, NOW)[0].read_bytes()
    second = self_signed(tmp_path, (*NAMES, "10.0.0.7"), NOW)[0].read_bytes()
    assert second != first
    near_the_end = NOW + timedelta(days=VALID_DAYS - RENEW_DAYS + 1)
    assert self_signed(tmp_path, NAMES, near_the_end)[0].read_bytes() != second


def test_a_damaged_certificate_is_replaced(tmp_path: Path) -> None:
    certificate, _ = self_signed(tmp_path, NAMES, NOW)
    certificate.write_text("not a certificate")
    certificate, key = self_signed(tmp_path, NAMES, NOW)
    ssl.create_default_context(ssl.Purpose.CLIENT_AUTH).load_cert_chain(certificate, key)


def test_a_wildcard_address_stands_for_all_names_of_the_machine() -> None:
    assert {"127.0.0.1", "localhost"} <= set(local_addresses("0.0.0.0"))
    assert local_addresses("10.1.2.3") == ("10.1.2.3",)
