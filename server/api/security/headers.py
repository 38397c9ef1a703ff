"""Headers that restrict what pages may do in browsers. A plain ASGI layer without task groups and threads."""

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

CONTENT_SECURITY_POLICY = "; ".join(
    (
        "default-src 'self'",
        "script-src 'self'",
        "style-src 'self' 'unsafe-inline'",  # inline style attributes place map labels
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "worker-src 'self'",
        "manifest-src 'self'",
        "object-src 'none'",
        "base-uri 'none'",
        "form-action 'self'",
        "frame-ancestors 'none'",
    )
)
HEADERS = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",  # a ride's link is its secret
    "Permissions-Policy": "geolocation=(self), camera=(), microphone=()",
    "Cross-Origin-Opener-Policy": "same-origin",
    "X-Frame-Options": "DENY",
}
# Scripts, styles and pictures of a page: the rest is about documents, and the page has it. On a
# phone each file of the first load would cost 400 bytes more.
ASSET_HEADERS = {"X-Content-Type-Options": "nosniff"}
_ASSETS = "/assets/"
HSTS = "max-age=31536000"


class SecurityHeaders:
    """Adds HEADERS to every response that has none of its own; ASSET_HEADERS to files of pages."""

    def __init__(self, app: ASGIApp, with_tls: bool) -> None:
        self._app = app
        always = {"Strict-Transport-Security": HSTS} if with_tls else {}
        self._headers, self._asset_headers = HEADERS | always, ASSET_HEADERS | always

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        is_asset = scope["path"].startswith(_ASSETS)

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                is_file = is_asset and message["status"] in (200, 304)
                added = self._asset_headers if is_file else self._headers
                for name, value in added.items():
                    headers.setdefault(name, value)
            await send(message)

        await self._app(scope, receive, send_with_headers)
