"""Checks of what lies on the disk: folder, map, pages, certificate."""

import shutil
import ssl
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from cryptography import x509

from campusloop.live.certificate import RENEW_DAYS
from campusloop.operations.finding import Finding, bad, good, warning
from campusloop.shipped import DEFAULT_MAP
from contract.roads.load import MapError, load_map
from server.api.pages import find_page, read_pages
from server.key_file import BadKeyFile
from server.live_ports import CannotStart, fleet_rules
from server.push_key_file import push_identity_of
from server.settings import Settings
from server.ticket_key_file import ticket_keys_of

_MIB = 1024 * 1024


@dataclass(frozen=True, slots=True)
class KeyFile:
    """One of the server's files of keys.

    known_by  who holds what was made with the key, if it is lost
    without   what happens to them then
    """

    check: str
    path: Path
    setting: str
    known_by: str
    without: str


def check_folder(settings: Settings) -> Finding:
    """Files can be made under var_dir, or where it will be made, and there is enough room."""
    folder = present = settings.var_dir.absolute()
    try:
        present = next(path for path in (folder, *folder.parents) if path.exists())
        with tempfile.TemporaryFile(dir=present):
            free = shutil.disk_usage(present).free
    except OSError as error:
        return bad(
            "folder",
            f"{present} cannot be written ({error.strerror})",
            "give its folder to the server's user (chown), or set CAMPUSLOOP_VAR_DIR",
        )
    if free < settings.disk_free_bytes_min:
        return bad(
            "folder",
            f"{present} has {free // _MIB} MiB free, fewer than {settings.disk_free_bytes_min // _MIB}",
            "delete old run segments or backups, or set CAMPUSLOOP_DISK_FREE_BYTES_MIN",
        )
    made = "" if present == folder else ", made at the first start"
    return good("folder", f"{folder}{made}; {free // _MIB} MiB free")


def check_push_key(settings: Settings) -> Finding:
    """The key of messages to phones can be read, by the server's user only. Makes none."""
    return _check_key(
        settings,
        KeyFile(
            "push key",
            settings.push_key(),
            "CAMPUSLOOP_PUSH_KEY_FILE",
            "phones that asked for news of their rides know the former key",
            "with a new key these phones hear of no ride until they ask again",
        ),
        lambda path: f"{path}, public key {push_identity_of(path).public_key[:12]}…",
    )


def check_ticket_keys(settings: Settings) -> Finding:
    """The keys of passengers' links can be read, by the server's user only. Makes none."""
    return _check_key(
        settings,
        KeyFile(
            "ticket keys",
            settings.ticket_keys(),
            "CAMPUSLOOP_TICKET_KEY_FILE",
            "the database may hold rides whose links were made with it",
            "without it the server refuses to start if there are such rides",
        ),
        _ticket_keys_in,
    )


def _ticket_keys_in(path: Path) -> str:
    keys = ticket_keys_of(path)
    return f"{len(keys.ids)} in {path}, newest {keys.newest_id}"


def _check_key(settings: Settings, key: KeyFile, read: Callable[[Path], str]) -> Finding:
    """`read` says what is in the file; it raises BadKeyFile or OSError."""
    path = key.path
    if not path.exists():
        if (settings.var_dir / "campusloop.db").exists():
            lost = f"{path} is missing, and {key.known_by}"
            return warning(key.check, lost, f"put the file back; {key.without}")
        return good(key.check, f"{path}, made at the first start")
    try:
        found = read(path)
        is_open = path.stat().st_mode & 0o077
    except (BadKeyFile, OSError) as error:
        return bad(key.check, str(error), f"put the old file back, or set {key.setting}")
    if is_open:
        return warning(key.check, f"{path} can be read or changed by other users", f"chmod 600 {path}")
    return good(key.check, found)


def check_map(settings: Settings) -> Finding:
    """The map can be read and is sound, and its service hours can be used."""
    path = settings.map_path or DEFAULT_MAP
    try:
        road_map = load_map(path)
        fleet_rules(settings, road_map)
    except MapError as error:
        return bad("map", f"{path}: {error.detail}", "set CAMPUSLOOP_MAP_PATH; see campusloop map import")
    except CannotStart as error:
        return bad("map", str(error), "set both as HH:MM")
    return good("map", f"{road_map.campus_id}, {len(road_map.stops)} stops, version {road_map.map_version}")


def check_pages(settings: Settings) -> Finding:
    try:
        pages = read_pages(settings.web_dist)
    except OSError as error:
        return bad("pages", f"{settings.web_dist} cannot be read ({error})", "mend its permissions")
    missing = [name for name in ("/", "/console") if find_page(pages, name) is None]
    if missing:
        return bad(
            "pages",
            f"{settings.web_dist.absolute()} has no page for {' and '.join(missing)}",
            "build them (make web), or set CAMPUSLOOP_WEB_DIST",
        )
    return good("pages", f"{len(pages)} files in {settings.web_dist.absolute()}")


def check_certificate(settings: Settings, now: datetime) -> Finding:
    if not settings.has_tls():
        if settings.is_loopback():
            return good("tls", "none needed: the server listens on this machine only")
        return good("tls", "none given: serve makes a certificate of its own and renews it")
    assert settings.tls_cert is not None
    renew = "get a new certificate for CAMPUSLOOP_TLS_CERT and restart the server"
    try:
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        context.load_cert_chain(settings.tls_cert, settings.tls_key)
        certificate = x509.load_pem_x509_certificate(Path(settings.tls_cert).read_bytes())
    except (OSError, ssl.SSLError, ValueError) as error:
        return bad(
            "tls", f"{settings.tls_cert} and {settings.tls_key} cannot be used ({error})",
            "give a PEM certificate and its key that the server's user may read",
        )  # fmt: skip
    begins, ends = certificate.not_valid_before_utc, certificate.not_valid_after_utc
    days = (ends - now).days
    if ends <= now:
        return bad("tls", f"the certificate expired on {ends:%Y-%m-%d}", renew)
    if begins > now:
        return bad("tls", f"the certificate begins on {begins:%Y-%m-%d}", f"set the clock, or {renew}")
    if days < RENEW_DAYS:
        return warning("tls", f"the certificate expires in {days} days", renew)
    return good("tls", f"the certificate is valid for {days} more days")
