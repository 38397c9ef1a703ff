"""Files and headers of the onboard screen. Nothing is loaded from another address."""

import mimetypes
from dataclasses import dataclass
from pathlib import Path

HEADERS = {
    "Content-Security-Policy": "; ".join(
        (
            "default-src 'self'",
            "style-src 'self' 'unsafe-inline'",  # inline style attributes place map labels
            "img-src 'self' data:",
            "object-src 'none'",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        )
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Permissions-Policy": "geolocation=(), camera=(), microphone=()",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Frame-Options": "DENY",
}


@dataclass(frozen=True, slots=True)
class ScreenFile:
    body: bytes
    media_type: str
    cache_control: str


def read_screen_files(pages: Path, vehicle_id: str, screen_map: bytes) -> dict[str, ScreenFile]:
    """Every file by its address: the page, its map, and the scripts and styles of the built pages."""
    page = (pages / "onboard.html").read_bytes()
    files = {
        f"/onboard/{vehicle_id}": ScreenFile(page, "text/html; charset=utf-8", "no-cache"),
        f"/onboard/{vehicle_id}/map.json": ScreenFile(screen_map, "application/json", "no-cache"),
    }
    for path in sorted([*pages.glob("assets/*"), *pages.glob("icon.svg")]):
        if path.suffix == ".br" or not path.is_file():
            continue
        address = "/" + path.relative_to(pages).as_posix()
        for_ever = "no-cache" if path.name == "icon.svg" else "public, max-age=31536000, immutable"
        media_type = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
        files[address] = ScreenFile(path.read_bytes(), media_type, for_ever)
    return files
