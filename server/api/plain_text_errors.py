"""Turns plain-text errors of libraries into problem details."""

from http import HTTPStatus

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.api.problems import http_problem

PLAIN = b"text/plain"


class PlainTextErrors:
    """Replaces a plain-text answer of status 400 and more under `/api/`."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or not scope["path"].startswith("/api/"):
            await self._app(scope, receive, send)
            return
        replaced = False

        async def send_problem(message: Message) -> None:
            nonlocal replaced
            if replaced:
                return
            if message["type"] == "http.response.start" and _is_plain_refusal(message):
                replaced = True
                status = HTTPStatus(message["status"])
                await http_problem(status, status.phrase)(scope, receive, send)
                return
            await send(message)

        await self._app(scope, receive, send_problem)


def _is_plain_refusal(start: Message) -> bool:
    headers = dict(start.get("headers", ()))
    plain: bool = headers.get(b"content-type", b"").startswith(PLAIN)
    return bool(start["status"] >= 400) and plain
