"""Self-signed certificates, so that phones on the campus network can use the pages over TLS."""

import ipaddress
import os
import socket
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

# Browsers refuse certificates that are valid for longer than 398 days.
VALID_DAYS = 397
RENEW_DAYS = 30


def local_addresses(host: str) -> tuple[str, ...]:
    """The names and addresses of this machine when it listens on `host`, sorted."""
    if host not in {"0.0.0.0", "::", ""}:
        return (host,)
    name = socket.gethostname()
    found = {"localhost", "127.0.0.1", name}
    for family, target in ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1")):
        address = _source_address(family, target)
        if address is not None:
            found.add(address)
    return tuple(sorted(found))


def _source_address(family: socket.AddressFamily, target: str) -> str | None:
    # Connecting a datagram socket sends nothing; it only makes the kernel choose the outgoing address.
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((target, 9))
        except OSError:
            return None  # no route in this family
        address: str = probe.getsockname()[0]
        return address


def self_signed(folder: Path, names: tuple[str, ...], now: datetime | None = None) -> tuple[Path, Path]:
    """(certificate, key) as PEM files in `folder`. Creates them if absent, near expiry or for other names."""
    now = now or datetime.now(UTC)
    certificate_path, key_path = folder / "certificate.pem", folder / "key.pem"
    if key_path.exists() and _is_usable(certificate_path, names, now):
        return certificate_path, key_path
    folder.mkdir(parents=True, exist_ok=True)
    key = ec.generate_private_key(ec.SECP256R1())
    pem = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    key_path.unlink(missing_ok=True)
    with os.fdopen(os.open(key_path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(pem)
    certificate = _certificate(key, names, now)
    certificate_path.write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    return certificate_path, key_path


def _certificate(key: ec.EllipticCurvePrivateKey, names: tuple[str, ...], now: datetime) -> x509.Certificate:
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "Campusloop")])
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(hours=1))
        .not_valid_after(now + timedelta(days=VALID_DAYS))
        .add_extension(x509.SubjectAlternativeName([_general_name(name) for name in names]), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
    )
    return builder.sign(key, hashes.SHA256())


def _general_name(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)


def _is_usable(path: Path, names: tuple[str, ...], now: datetime) -> bool:
    if not path.exists():
        return False
    try:
        certificate = x509.load_pem_x509_certificate(path.read_bytes())
    except ValueError:
        return False
    covered = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    needed = {_general_name(name) for name in names}
    return needed <= set(covered) and certificate.not_valid_after_utc - now > timedelta(days=RENEW_DAYS)
