"""The built web pages: passenger at `/`, console at `/console`, read into memory once at start-up.

They are a few hundred kilobytes; from memory they need no thread, and a half-finished rebuild is never
served. They are sent compressed; the build leaves the brotli form of `FILE` as `FILE.br`. Files with a
content hash in their name are kept by browsers for ever, all others are revalidated. Passenger page and
console keep their address in the fragment, a board has its stop in the path: every other path is no page.
"""

import hashlib
import mimetypes
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from server.api.content_coding import CodedBody, coded_body

HASHED_NAME = re.compile(r"[.-][0-9A-Za-z_-]{8,}\.\w+$")
FOR_EVER = "public, max-age=31536000, immutable"
REVALIDATE = "no-cache"

MISSING_PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Campusloop</title>
<h1>The web pages are not built yet</h1>
<p>Run <code>make web</code> in the project and start the server again. The API works already:
<a href="/api/v1/openapi.json">/api/v1/openapi.json</a>.</p></html>
"""

NO_SUCH_PAGE = """<!doctype html><html lang="en"><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>No such page - Campusloop</title>
<h1>There is no page at this address</h1>
<p>Look for a mistake in it, or go on here: <a href="/">book a ride</a>.</p>
<p lang="zh">此网址没有页面。请检查网址，或<a href="/">预订行程</a>。</p></html>
"""
BROTLI = ".br"


@dataclass(frozen=True, slots=True)
class Page:
    body: CodedBody
    media_type: str
    etag: str
    cache_control: str


def read_pages(folder: Path) -> dict[str, Page]:
    """Every file below `folder` by its URL path; empty when the folder is not there."""
    if not folder.is_dir():
        return {}
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.suffix != BROTLI)
    return {"/" + path.relative_to(folder).as_posix(): _page(path) for path in files}


def _page(path: Path) -> Page:
    body, brotli = path.read_bytes(), path.with_name(path.name + BROTLI)
    media_type = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
    if path.suffix == ".webmanifest":
        media_type = "application/manifest+json"
    cache_control = FOR_EVER if HASHED_NAME.search(path.name) and path.suffix != ".html" else REVALIDATE
    coded = coded_body(body, brotli.read_bytes() if brotli.is_file() else None)
    return Page(coded, media_type, f'"{hashlib.sha256(body).hexdigest()[:32]}"', cache_control)


def find_page(pages: Mapping[str, Page], path: str) -> Page | None:
    """The page of a URL path; `/`, `/console` and `/board/STOP` are the shells of the applications."""
    if path in pages:
        return pages[path]
    if path in ("/console", "/console/"):
        return pages.get("/console/index.html") or pages.get("/console.html")
    if path.startswith("/board/"):
        return pages.get("/board.html")
    return pages.get("/index.html") if path == "/" else None


def page_response(pages: Mapping[str, Page], request: Request) -> Response:
    """200, 304 when the browser has it, 404 when there is none (saying how to build the pages)."""
    if not pages:
        return HTMLResponse(MISSING_PAGE, status_code=404, headers={"Cache-Control": "no-store"})
    page = find_page(pages, request.url.path)
    if page is None:
        return HTMLResponse(NO_SUCH_PAGE, status_code=404, headers={"Cache-Control": "no-store"})
    headers = {"Cache-Control": page.cache_control}
    # Of the plain body or of a coded one: either means that the browser has it.
    if page.etag.strip('"') in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers | {"ETag": page.etag, "Vary": "Accept-Encoding"})
    accepted = request.headers.get("accept-encoding", "")
    return page.body.response(accepted, page.media_type, page.etag, headers)
