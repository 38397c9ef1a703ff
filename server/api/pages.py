"""The built web pages: passenger at `/`, console at `/console`, read into memory once at start-up.

They are a few hundred kilobytes; from memory they need no thread, and a half-finished rebuild is never
served. Files with a content hash in their name are kept by browsers for ever, all others are revalidated.
"""

import hashlib
import mimetypes
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

HASHED_NAME = re.compile(r"[.-][0-9A-Za-z_-]{8,}\.\w+$")
FOR_EVER = "public, max-age=31536000, immutable"
REVALIDATE = "no-cache"

MISSING_PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Campusloop</title>
<h1>The web pages are not built yet</h1>
<p>Run <code>make web</code> in the project and start the server again. The API works already:
<a href="/api/v1/openapi.json">/api/v1/openapi.json</a>.</p></html>
"""


@dataclass(frozen=True, slots=True)
class Page:
    body: bytes
    media_type: str
    etag: str
    cache_control: str


def read_pages(folder: Path) -> dict[str, Page]:
    """Every file below `folder` by its URL path; empty when the folder is not there."""
    if not folder.is_dir():
        return {}
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {"/" + path.relative_to(folder).as_posix(): _page(path) for path in files}


def _page(path: Path) -> Page:
    body = path.read_bytes()
    media_type = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
    if path.suffix == ".webmanifest":
        media_type = "application/manifest+json"
    cache_control = FOR_EVER if HASHED_NAME.search(path.name) and path.suffix != ".html" else REVALIDATE
    return Page(body, media_type, f'"{hashlib.sha256(body).hexdigest()[:32]}"', cache_control)


def find_page(pages: Mapping[str, Page], path: str) -> Page | None:
    """The page of a URL path. Routes of the two applications (`/ride/x`, `/console/runs`) get their shell."""
    if path in pages:
        return pages[path]
    if "." in path.rsplit("/", 1)[-1]:
        return None
    if path == "/console" or path.startswith("/console/"):
        return pages.get("/console/index.html") or pages.get("/console.html")
    return pages.get("/index.html")


def page_response(pages: Mapping[str, Page], request: Request) -> Response:
    """200, 304 when the browser has it, 404 when there is none (saying how to build the pages)."""
    if not pages:
        return HTMLResponse(MISSING_PAGE, status_code=404, headers={"Cache-Control": "no-store"})
    page = find_page(pages, request.url.path)
    if page is None:
        return HTMLResponse("<!doctype html><title>404</title><h1>No such page</h1>", status_code=404)
    headers = {"ETag": page.etag, "Cache-Control": page.cache_control}
    if page.etag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    return Response(page.body, media_type=page.media_type, headers=headers)
